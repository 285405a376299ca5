"""Runs of flow models on the terrain of paths."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go to this revision."""
    op.create_table(
        "simulations",
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("engine", sa.String(length=200), nullable=False),
        sa.Column("friction", sa.Double(precision=53), nullable=False),
        sa.Column("volume_m3", sa.Double(precision=53), nullable=False),
        sa.Column("drag_per_m", sa.Double(precision=53), nullable=False),
        sa.Column("ground", sa.String(length=64), nullable=False),
        sa.Column("stop_x_m", sa.Double(precision=53), nullable=True),
        sa.Column("left_profile", sa.Boolean(), nullable=False),
        sa.Column("seconds", sa.Double(precision=53), nullable=False),
        sa.Column("n_rows", sa.Integer(), nullable=False),
        sa.Column("n_columns", sa.Integer(), nullable=False),
        sa.Column("data", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["path_id"], ["paths.path_id"], name=op.f("fk_simulations_path_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint(
            "path_id", "engine", "friction", "volume_m3", "drag_per_m", name=op.f("pk_simulations")
        ),
    )


def downgrade() -> None:
    """Go back to the revision before."""
    op.drop_table("simulations")
