"""What a failed try has written, overdue evaluations in two hands, priorities, jobs whose failures are run again."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add what is new; nothing that is there changes its meaning."""
    op.add_column("jobs", sa.Column("priority", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("retry_to", sa.String(length=16), nullable=True))
    op.add_column("evaluations", sa.Column("log", sa.Text(), nullable=True))
    op.add_column("evaluations", sa.Column("duplicates", sa.Integer(), nullable=True))
    op.add_column("attempts", sa.Column("log", sa.Text(), nullable=True))
    op.create_index(
        "ix_evaluations_reopened",
        "evaluations",
        ["job_id", "generation"],
        unique=False,
        postgresql_where=sa.text("state = 'pending' AND reason IS NOT NULL"),
        sqlite_where=sa.text("state = 'pending' AND reason IS NOT NULL"),
    )
