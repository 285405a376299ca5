"""All that a database holds, as sets of rows that can be compared with those of another."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

from sqlalchemy import LargeBinary, MetaData, select
from sqlalchemy.types import JSON

from avahazard.store.session import make_engine
from avahazard.store.tables import Base

RECORDS = frozenset({"paths", "profile_points", "events", "speeds", "terrain"})
# Numbers that a server gives out anew, moments, and checksums over them, which `db check` verifies.
PASSING = frozenset({"id", "created", "finished", "calibration", "run", "sha256"})

Table = Counter[str]
Contents = dict[str, Table]


def contents(database: str) -> Contents:
    """The rows of every table of `database`, whatever its revision."""
    engine = make_engine(database, migrates=True)
    try:
        with engine.connect() as connection:
            found = MetaData()
            found.reflect(connection)
            rows: Contents = {}
            for name, table in found.tables.items():
                for column in table.columns:  # a document's spaces are no difference
                    known = Base.metadata.tables.get(name)
                    if known is not None and column.name in known.c:
                        kind = known.c[column.name].type
                        if isinstance(kind, JSON | LargeBinary):
                            column.type = kind
                kept = [c for c in table.columns if c.name not in PASSING]
                rows[name] = Counter(
                    _text(dict(row._mapping)) for row in connection.execute(select(*kept))
                )
            return rows
    finally:
        engine.dispose()


def _text(row: dict[str, Any]) -> str:
    return json.dumps(row, sort_keys=True, default=lambda v: getattr(v, "hex", lambda: str(v))())


def same_rows(now: Contents, then: Contents) -> bool:
    """Whether two databases hold the same rows, however often.

    A command that had ended before it was killed stores its answer once more when it is run again.
    """
    return {name: set(rows) for name, rows in now.items()} == {
        name: set(rows) for name, rows in then.items()
    }


def faults(now: Contents, before: Contents, after: Contents) -> list[str]:
    """What is wrong with a database whose command was killed between `before` and `after`.

    What stood before and was to stay is there, nothing is there that neither state has, and
    records are those of the one or of the other.
    """
    found = []
    for name in sorted(before.keys() | after.keys() | now.keys()):
        a, b, there = (rows.get(name, Counter()) for rows in (before, after, now))
        if (a & b) - there:
            found.append(f"{name}: {((a & b) - there).total()} rows are lost")
        if there - (a | b):
            found.append(f"{name}: {(there - (a | b)).total()} rows are none of the command's")
    for names, what in ((RECORDS, "records"), ({"models", "draw_chunks", "calibrations"}, "model")):
        mine = [{n: rows[n] for n in names if n in rows} for rows in (now, before, after)]
        if mine[0] not in mine[1:]:
            found.append(f"the {what} are stored in part")
    return found
