"""Records, models and results."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go to this revision."""
    op.create_table(
        "models",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("parent", sa.String(length=200), nullable=True),
        sa.Column("specification", sa.JSON(), nullable=False),
        sa.Column("effect_file", sa.Text(), nullable=True),
        sa.Column("effect_sha256", sa.String(length=64), nullable=True),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.ForeignKeyConstraint(["parent"], ["models.name"], name=op.f("fk_models_parent")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_models")),
        sa.UniqueConstraint("name", name=op.f("uq_models_name")),
    )
    op.create_table(
        "paths",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("name", sa.Text(), nullable=True),
        sa.Column("location", sa.Text(), nullable=True),
        sa.Column("orientation", sa.Text(), nullable=True),
        sa.Column("section", sa.Text(), nullable=True),
        sa.Column("catchment_ha", sa.Double(precision=53), nullable=True),
        sa.Column("release_elevation_m", sa.Double(precision=53), nullable=True),
        sa.Column("observed_from", sa.Integer(), nullable=True),
        sa.Column("observed_to", sa.Integer(), nullable=True),
        sa.Column("observed_below_m", sa.Double(precision=53), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_paths")),
        sa.UniqueConstraint("path_id", name=op.f("uq_paths_path_id")),
    )
    op.create_table(
        "calibrations",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(length=200), nullable=False),
        sa.Column("settings", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("data_fingerprint", sa.String(length=64), nullable=False),
        sa.Column("diagnostics", sa.JSON(), nullable=False),
        sa.Column("converged", sa.Boolean(), nullable=False),
        sa.Column("result", sa.JSON(), nullable=False),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.ForeignKeyConstraint(
            ["model"], ["models.name"], name=op.f("fk_calibrations_model"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_calibrations")),
    )
    op.create_index(op.f("ix_calibrations_model"), "calibrations", ["model"], unique=False)

    op.create_table(
        "comparisons",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(length=200), nullable=False),
        sa.Column("result", sa.JSON(), nullable=False),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.ForeignKeyConstraint(
            ["model"], ["models.name"], name=op.f("fk_comparisons_model"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_comparisons")),
    )
    op.create_index(op.f("ix_comparisons_model"), "comparisons", ["model"], unique=False)

    op.create_table(
        "events",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("event_id", sa.String(length=200), nullable=False),
        sa.Column("path_id", sa.String(length=200), nullable=True),
        sa.Column("date", sa.Text(), nullable=True),
        sa.Column("runout_elevation_m", sa.Double(precision=53), nullable=True),
        sa.Column("runout_x_m", sa.Double(precision=53), nullable=True),
        sa.Column("runout_sigma_m", sa.Double(precision=53), nullable=False),
        sa.Column("left_profile", sa.Boolean(), nullable=False),
        sa.Column("release_elevation_m", sa.Double(precision=53), nullable=True),
        sa.Column("volume_m3", sa.Double(precision=53), nullable=True),
        sa.Column("deposit_length_m", sa.Double(precision=53), nullable=True),
        sa.Column("deposit_width_m", sa.Double(precision=53), nullable=True),
        sa.Column("deposit_thickness_m", sa.Double(precision=53), nullable=True),
        sa.Column("volume_rel_sigma", sa.Double(precision=53), nullable=False),
        sa.Column("fall_height_m", sa.Double(precision=53), nullable=True),
        sa.Column("runout_length_m", sa.Double(precision=53), nullable=True),
        sa.ForeignKeyConstraint(["path_id"], ["paths.path_id"], name=op.f("fk_events_path_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_events")),
        sa.UniqueConstraint("event_id", name=op.f("uq_events_event_id")),
    )
    op.create_index(op.f("ix_events_path_id"), "events", ["path_id"], unique=False)

    op.create_table(
        "hazard_results",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(length=200), nullable=False),
        sa.Column("result", sa.JSON(), nullable=False),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.ForeignKeyConstraint(
            ["model"], ["models.name"], name=op.f("fk_hazard_results_model"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_hazard_results")),
    )
    op.create_index(op.f("ix_hazard_results_model"), "hazard_results", ["model"], unique=False)

    op.create_table(
        "path_covariates",
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("number", sa.Double(precision=53), nullable=True),
        sa.Column("word", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(
            ["path_id"],
            ["paths.path_id"],
            name=op.f("fk_path_covariates_path_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("path_id", "name", name=op.f("pk_path_covariates")),
    )
    op.create_table(
        "profile_points",
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("point", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("x_m", sa.Double(precision=53), nullable=False),
        sa.Column("y_m", sa.Double(precision=53), nullable=False),
        sa.Column("land_cover", sa.Text(), nullable=True),
        sa.Column("easting_m", sa.Double(precision=53), nullable=True),
        sa.Column("northing_m", sa.Double(precision=53), nullable=True),
        sa.Column("crs", sa.Text(), nullable=True),
        sa.Column("lon", sa.Double(precision=53), nullable=True),
        sa.Column("lat", sa.Double(precision=53), nullable=True),
        sa.ForeignKeyConstraint(
            ["path_id"],
            ["paths.path_id"],
            name=op.f("fk_profile_points_path_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("path_id", "point", name=op.f("pk_profile_points")),
    )
    op.create_table(
        "draw_chunks",
        sa.Column("calibration", sa.Integer(), nullable=False),
        sa.Column("parameter", sa.String(length=200), nullable=False),
        sa.Column("chunk", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("n_chains", sa.Integer(), nullable=False),
        sa.Column("n_draws", sa.Integer(), nullable=False),
        sa.Column("data", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["calibration"],
            ["calibrations.id"],
            name=op.f("fk_draw_chunks_calibration"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("calibration", "parameter", "chunk", name=op.f("pk_draw_chunks")),
    )
    op.create_table(
        "event_covariates",
        sa.Column("event_id", sa.String(length=200), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("number", sa.Double(precision=53), nullable=True),
        sa.Column("word", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(
            ["event_id"],
            ["events.event_id"],
            name=op.f("fk_event_covariates_event_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("event_id", "name", name=op.f("pk_event_covariates")),
    )
    op.create_table(
        "speeds",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("event_id", sa.String(length=200), nullable=False),
        sa.Column("x_m", sa.Double(precision=53), nullable=True),
        sa.Column("elevation_m", sa.Double(precision=53), nullable=True),
        sa.Column("speed_m_s", sa.Double(precision=53), nullable=False),
        sa.Column("speed_sigma_m_s", sa.Double(precision=53), nullable=False),
        sa.ForeignKeyConstraint(
            ["event_id"], ["events.event_id"], name=op.f("fk_speeds_event_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_speeds")),
    )
    op.create_index(op.f("ix_speeds_event_id"), "speeds", ["event_id"], unique=False)


def downgrade() -> None:
    """Go back to the revision before."""
    op.drop_index(op.f("ix_speeds_event_id"), table_name="speeds")

    op.drop_table("speeds")
    op.drop_table("event_covariates")
    op.drop_table("draw_chunks")
    op.drop_table("profile_points")
    op.drop_table("path_covariates")
    op.drop_index(op.f("ix_hazard_results_model"), table_name="hazard_results")

    op.drop_table("hazard_results")
    op.drop_index(op.f("ix_events_path_id"), table_name="events")

    op.drop_table("events")
    op.drop_index(op.f("ix_comparisons_model"), table_name="comparisons")

    op.drop_table("comparisons")
    op.drop_index(op.f("ix_calibrations_model"), table_name="calibrations")

    op.drop_table("calibrations")
    op.drop_table("paths")
    op.drop_table("models")
