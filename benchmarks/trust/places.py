"""Where databases of a study live: files of a folder, or databases of a PostgreSQL server."""

from __future__ import annotations

import os
import shutil
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import create_engine, make_url, text

SERVER = "AVAHAZARD_TEST_POSTGRES"


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
