"""Versions under which a job was calculated."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add their column; for jobs that are there already they are not known."""
    op.add_column("jobs", sa.Column("versions", sa.Text(), nullable=True))
