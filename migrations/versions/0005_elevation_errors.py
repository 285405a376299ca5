"""The error of the elevations of a profile is kept."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go to this revision."""
    with op.batch_alter_table("profile_points") as table:
        table.add_column(sa.Column("elevation_sigma_m", sa.Double(precision=53), nullable=True))


def downgrade() -> None:
    """Go back to the revision before."""
    with op.batch_alter_table("profile_points") as table:
        table.drop_column("elevation_sigma_m")
