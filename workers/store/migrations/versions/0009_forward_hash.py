"""What must be equal in jobs that offer runs to each other."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the hash of the forward model; that of a job which is there already is found when it is first asked for."""
    op.add_column("jobs", sa.Column("forward_hash", sa.String(length=64), nullable=True))
