"""Keys that show one job only, the secrets of read-only links. Follow-ups know their job, to be listed below it."""

from __future__ import annotations

import json

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

JOBS_A_LOOK = 500


def upgrade() -> None:
    """Add the columns, and fill that of follow-ups from the stored problems.

    A follow-up is of the same owner as its job, or an administrator's, who sees all jobs: without an owner, or of an
    owner who was given such a key.
    """
    op.add_column("api_keys", sa.Column("job_id", sa.String(length=32), nullable=True))
    op.add_column("jobs", sa.Column("parent", sa.String(length=32), nullable=True))
    op.create_index("ix_jobs_parent", "jobs", ["parent"])
    jobs = sa.table("jobs", *(sa.column(name) for name in ("id", "owner", "problem", "parent")))
    keys = sa.table("api_keys", *(sa.column(name) for name in ("owner", "role")))
    connection = op.get_bind()
    see_all = {None, *connection.scalars(sa.select(keys.c.owner).where(keys.c.role == "admin"))}
    naming = sa.select(jobs.c.id, jobs.c.owner, jobs.c.problem).where(jobs.c.problem.like('%"of":"%'))
    last = ""
    while rows := connection.execute(naming.where(jobs.c.id > last).order_by(jobs.c.id).limit(JOBS_A_LOOK)).all():
        last = rows[-1].id
        for row in rows:
            of = json.loads(row.problem)["method"].get("of")
            followed = connection.execute(sa.select(jobs.c.owner).where(jobs.c.id == of)).one_or_none()
            if followed is not None and (row.owner in see_all or followed.owner == row.owner):
                connection.execute(sa.update(jobs).where(jobs.c.id == row.id).values(parent=of))
