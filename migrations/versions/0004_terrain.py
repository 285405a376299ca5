"""The ground around paths is kept."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go to this revision."""
    op.create_table(
        "terrain_crops",
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("crs", sa.Text(), nullable=False),
        sa.Column("west_m", sa.Double(precision=53), nullable=False),
        sa.Column("north_m", sa.Double(precision=53), nullable=False),
        sa.Column("cell_m", sa.Double(precision=53), nullable=False),
        sa.Column("n_rows", sa.Integer(), nullable=False),
        sa.Column("n_columns", sa.Integer(), nullable=False),
        sa.Column("data", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["path_id"],
            ["paths.path_id"],
            name=op.f("fk_terrain_crops_path_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("path_id", name=op.f("pk_terrain_crops")),
    )


def downgrade() -> None:
    """Go back to the revision before."""
    op.drop_table("terrain_crops")
