"""Chunks of draws and results have checksums; what is there already is taken as it stands."""

from __future__ import annotations

import hashlib
import json

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

RESULTS = ("calibrations", "comparisons", "diagnoses")
ALL = (*RESULTS, "path_results", "draw_chunks")
PLACE = ("calibration", "parameter", "chunk")


def upgrade() -> None:
    """Go to this revision."""
    for name in ALL:
        with op.batch_alter_table(name) as table:
            table.add_column(sa.Column("sha256", sa.String(length=64), nullable=True))
    for name in RESULTS:
        _sum_results(name)
    _sum_path_results()
    _sum_chunks()
    for name in ALL:
        with op.batch_alter_table(name) as table:
            table.alter_column("sha256", existing_type=sa.String(length=64), nullable=False)


def downgrade() -> None:
    """Go back to the revision before."""
    for name in ALL:
        with op.batch_alter_table(name) as table:
            table.drop_column("sha256")


def _sum_results(name: str) -> None:
    bind = op.get_bind()
    rows = sa.table(
        name, sa.column("id"), sa.column("model"), sa.column("result", sa.JSON), sa.column("sha256")
    )
    for key in bind.scalars(sa.select(rows.c.id)).all():
        query = sa.select(rows.c.model, rows.c.result).where(rows.c.id == key)
        model, document = bind.execute(query).one()
        text = json.dumps(document, sort_keys=True, ensure_ascii=False)
        digest = hashlib.sha256(f"{model}\n{text}".encode()).hexdigest()
        bind.execute(sa.update(rows).where(rows.c.id == key).values(sha256=digest))


def _sum_path_results() -> None:
    bind = op.get_bind()
    told = ("run", "position", "path_id", "result", "notes", "failed")
    json_columns = ("result", "notes")
    rows = sa.table(
        "path_results",
        *(sa.column(name, sa.JSON) if name in json_columns else sa.column(name) for name in told),
        sa.column("sha256"),
    )
    for run, position in bind.execute(sa.select(rows.c.run, rows.c.position)).all():
        here = sa.and_(rows.c.run == run, rows.c.position == position)
        found = bind.execute(sa.select(*(rows.c[name] for name in told)).where(here)).one()
        text = json.dumps(list(found), sort_keys=True, ensure_ascii=False)
        digest = hashlib.sha256(text.encode()).hexdigest()
        bind.execute(sa.update(rows).where(here).values(sha256=digest))


def _sum_chunks() -> None:
    bind = op.get_bind()
    names = (*PLACE, "n_chains", "n_draws", "data", "sha256")
    rows = sa.table("draw_chunks", *(sa.column(name) for name in names))
    for key in bind.execute(sa.select(*(rows.c[name] for name in PLACE))).all():
        here = sa.and_(*(rows.c[name] == value for name, value in zip(PLACE, key, strict=True)))
        query = sa.select(rows.c.n_chains, rows.c.n_draws, rows.c.data).where(here)
        n_chains, n_draws, data = bind.execute(query).one()
        place = f"{key[0]}\n{key[1]}\n{key[2]}\n{n_chains} {n_draws}\n".encode()
        digest = hashlib.sha256(place + bytes(data)).hexdigest()
        bind.execute(sa.update(rows).where(here).values(sha256=digest))
