"""Events of which H/L alone is known."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go to this revision."""
    with op.batch_alter_table("events") as table:
        table.add_column(sa.Column("h_over_l", sa.Double(precision=53), nullable=True))


def downgrade() -> None:
    """Go back to the revision before."""
    with op.batch_alter_table("events") as table:
        table.drop_column("h_over_l")
