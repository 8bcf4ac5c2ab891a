"""Turns of owners, and what jobs take of the disk."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

OPEN = sa.text("state IN ('queued', 'running')")


def upgrade() -> None:
    """Add what is new; jobs that are there already keep their place in the line of their owner."""
    op.add_column("jobs", sa.Column("line", sa.String(length=80), nullable=False, server_default=""))
    op.add_column("jobs", sa.Column("place", sa.Double(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("shared_priority", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("document_bytes", sa.BigInteger(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("evaluation_bytes", sa.BigInteger(), nullable=False, server_default="0"))
    # A list of n numbers as JSON has n - 1 commas.
    op.execute(
        "UPDATE jobs SET line = coalesce(owner, ''), place = coalesce(served_at, created_at - 10) - 10 * priority,"
        " document_bytes = length(problem) + length(grids) + 4096,"
        " evaluation_bytes = 600 + 8 * (2 + length(grids) - length(replace(grids, ',', ''))"
        " + length(free_parameters) - length(replace(free_parameters, ',', '')))"
    )
    for names in (["line", "place"], ["place"]):
        name = "_".join(["ix_jobs", *names])
        op.create_index(name, "jobs", names, unique=False, postgresql_where=OPEN, sqlite_where=OPEN)
    op.create_table(
        "turns",
        sa.Column("line", sa.String(length=80), nullable=False),
        sa.Column("served_at", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("line", name=op.f("pk_turns")),
    )
    op.execute("INSERT INTO turns (line, served_at) SELECT line, max(served_at) FROM jobs GROUP BY line")
