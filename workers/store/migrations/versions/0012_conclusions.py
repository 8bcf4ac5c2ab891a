"""Intervals and verdicts of jobs beside their parameters, and which of these lie at a bound."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; what jobs have found before is in their statistics only."""
    op.add_column("jobs", sa.Column("search_evaluations", sa.BigInteger(), nullable=True))
    op.add_column("jobs", sa.Column("answer_evaluations", sa.BigInteger(), nullable=True))
    op.add_column("jobs", sa.Column("at_bounds", sa.Text(), nullable=True))
    op.add_column("jobs", sa.Column("conclusion", sa.Text(), nullable=True))
