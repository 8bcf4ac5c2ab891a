"""Stop criteria that were changed after a job was submitted."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add their column."""
    op.add_column("jobs", sa.Column("stopping", sa.Text(), nullable=True))
