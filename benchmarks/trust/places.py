"""Databases of a study, as files or on a PostgreSQL server, and what they hold."""

from __future__ import annotations

import json
import os
import shutil
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import LargeBinary, MetaData, create_engine, make_url, select, text
from sqlalchemy.types import JSON

from avahazard.store.session import make_engine
from avahazard.store.tables import Base

SERVER = "AVAHAZARD_TEST_POSTGRES"
RECORDS = frozenset({"paths", "profile_points", "events", "speeds", "terrain"})
# Numbers that a server gives out anew, moments, and checksums over them, which `db check` verifies.
PASSING = frozenset({"id", "created", "finished", "calibration", "run", "sha256"})
Table = Counter[str]
Contents = dict[str, Table]


@dataclass(frozen=True, slots=True)
class Files:
    """Databases as files; a copy is a copy of the file."""

    name = "SQLite"

    def new(self, folder: Path) -> str:
        """The place of a database that is not there yet."""
        return str(folder / "avahazard.db")

    def copy(self, database: str, folder: Path) -> str:
        """Copy a database that nobody uses into `folder`."""
        return str(shutil.copy(database, folder / "avahazard.db"))

    def settle(self, database: str) -> None:
        """Nothing: nobody works on for a process that is dead."""

    def drop(self, database: str) -> None:
        """Nothing: the folder goes with all that is in it."""


@dataclass(frozen=True, slots=True)
class Server:
    """Databases of a server that may be made and dropped; a copy is made from a template."""

    url: str
    name = "PostgreSQL"

    def new(self, _folder: Path) -> str:
        """An empty database."""
        return self._create("")

    def copy(self, database: str, _folder: Path) -> str:
        """Copy a database to which nobody is connected."""
        return self._create(f" TEMPLATE {make_url(database).database}")

    def settle(self, database: str) -> None:
        """Wait until the server sees that those who worked on a database are dead.

        It ends what it was asked for: a commit, say.
        """
        there = f"datname = '{make_url(database).database}' AND backend_type = 'client backend'"
        while self._run(f"SELECT count(*) FROM pg_stat_activity WHERE {there}"):
            time.sleep(0.002)

    def drop(self, database: str) -> None:
        """Drop a database, whoever may still be connected to it."""
        self._run(f"DROP DATABASE {make_url(database).database} WITH (FORCE)")

    def _create(self, how: str) -> str:
        name = f"trust_{uuid.uuid4().hex}"
        self._run(f"CREATE DATABASE {name}{how}")
        return make_url(self.url).set(database=name).render_as_string(hide_password=False)

    def _run(self, statement: str) -> Any:
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            result = connection.execute(text(statement))
            value = result.scalar() if result.returns_rows else None
        engine.dispose()
        return value


Place = Files | Server


def places() -> tuple[Place, ...]:
    """Files, and the server that `AVAHAZARD_TEST_POSTGRES` names, if it names one."""
    server = os.environ.get(SERVER)
    return (Files(), Server(server)) if server else (Files(),)


@contextmanager
def copied(place: Place, database: str, folder: Path) -> Iterator[str]:
    """A copy of a database in `folder`, which is made and removed."""
    folder.mkdir()
    copy = place.copy(database, folder)
    try:
        yield copy
    finally:
        place.drop(copy)
        shutil.rmtree(folder)


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
        selected = [{n: rows[n] for n in names if n in rows} for rows in (now, before, after)]
        if selected[0] not in selected[1:]:
            found.append(f"the {what} are stored in part")
    return found
