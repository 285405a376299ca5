"""Bounds and zones are kept path by path, each run with what it was asked for."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

OLD = {"hazard": "hazard_results", "zones": "zone_results"}
RUNS = sa.table(
    "path_runs",
    sa.column("id", sa.Integer),
    sa.column("kind", sa.String),
    sa.column("model", sa.String),
    sa.column("key", sa.String),
    sa.column("settings", sa.JSON),
    sa.column("created", sa.DateTime),
    sa.column("finished", sa.DateTime),
)
RESULTS = sa.table(
    "path_results",
    sa.column("run", sa.Integer),
    sa.column("position", sa.Integer),
    sa.column("path_id", sa.String),
    sa.column("result", sa.JSON),
    sa.column("notes", sa.JSON),
    sa.column("failed", sa.Text),
)


def _old(name: str) -> sa.TableClause:
    return sa.table(
        name,
        sa.column("id", sa.Integer),
        sa.column("model", sa.String),
        sa.column("result", sa.JSON),
        sa.column("created", sa.DateTime),
    )


def upgrade() -> None:
    """Go to this revision."""
    op.create_table(
        "path_runs",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("model", sa.String(length=200), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("settings", sa.JSON(), nullable=False),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.Column("finished", sa.DateTime(), nullable=True),
        sa.ForeignKeyConstraint(
            ["model"], ["models.name"], name=op.f("fk_path_runs_model"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_path_runs")),
    )
    op.create_index(op.f("ix_path_runs_model"), "path_runs", ["model"], unique=False)
    op.create_table(
        "path_results",
        sa.Column("run", sa.Integer(), nullable=False),
        sa.Column("position", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("path_id", sa.String(length=200), nullable=False),
        sa.Column("result", sa.JSON(), nullable=False),
        sa.Column("notes", sa.JSON(), nullable=False),
        sa.Column("failed", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(
            ["run"], ["path_runs.id"], name=op.f("fk_path_results_run"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("run", "position", name=op.f("pk_path_results")),
    )
    bind = op.get_bind()
    for kind, name in OLD.items():
        old = _old(name)
        for row in bind.execute(sa.select(old).order_by(old.c.id)).all():
            _move(bind, kind, row)
        op.drop_index(op.f(f"ix_{name}_model"), table_name=name)
        op.drop_table(name)


def _move(bind: sa.Connection, kind: str, row: Any) -> None:
    found = bind.execute(
        sa.insert(RUNS)
        .values(
            kind=kind,
            model=row.model,
            key="",
            settings={},
            created=row.created,
            finished=row.created,
        )
        .returning(RUNS.c.id)
    )
    run = found.scalar_one()
    by_path: dict[str, list[Any]] = {}
    for entry in row.result:
        by_path.setdefault(entry["path_id"], []).append(entry)
    for position, (path_id, entries) in enumerate(by_path.items()):
        bind.execute(
            sa.insert(RESULTS).values(
                run=run, position=position, path_id=path_id, result=entries, notes=[], failed=None
            )
        )


def downgrade() -> None:
    """Go back to the revision before."""
    bind = op.get_bind()
    for kind, name in OLD.items():
        op.create_table(
            name,
            sa.Column("id", sa.Integer(), nullable=False),
            sa.Column("model", sa.String(length=200), nullable=False),
            sa.Column("result", sa.JSON(), nullable=False),
            sa.Column("created", sa.DateTime(), nullable=False),
            sa.ForeignKeyConstraint(
                ["model"], ["models.name"], name=op.f(f"fk_{name}_model"), ondelete="CASCADE"
            ),
            sa.PrimaryKeyConstraint("id", name=op.f(f"pk_{name}")),
        )
        op.create_index(op.f(f"ix_{name}_model"), name, ["model"], unique=False)
        wanted = sa.select(RUNS).where(RUNS.c.kind == kind, RUNS.c.finished.is_not(None))
        for run in bind.execute(wanted.order_by(RUNS.c.id)).all():
            parts = sa.select(RESULTS.c.result).where(RESULTS.c.run == run.id)
            entries = bind.scalars(parts.order_by(RESULTS.c.position)).all()
            whole = [entry for part in entries for entry in part]
            bind.execute(
                sa.insert(_old(name)).values(model=run.model, result=whole, created=run.created)
            )
    op.drop_table("path_results")
    op.drop_index(op.f("ix_path_runs_model"), table_name="path_runs")
    op.drop_table("path_runs")
