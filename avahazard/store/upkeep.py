"""Making, upgrading, copying and checking a database."""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path as FilePath

from sqlalchemy import func, select, table, text
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.results.files import DatabaseState
from avahazard.store import tables
from avahazard.store.results import read_draws
from avahazard.store.session import database_name, database_url, engine_of, make_engine, sqlite_file
from avahazard.whole_file import written_whole

COUNTED = ("paths", "events", "speeds", "models", "calibrations")


def create(database: str) -> tables.State:
    """Create the tables of an empty or missing `database`, else refuse; return its state before."""
    return _migrate(database, make=True)


def upgrade(database: str) -> tables.State:
    """Run the migrations that an older `database` lacks, else refuse; return its state before."""
    return _migrate(database, make=False)


def status(database: str) -> DatabaseState:
    """Return the state of `database`. Raises `AvahazardError` where it cannot be read."""
    with engine_of(database) as engine, engine.connect() as connection:
        state = tables.state(connection)
        counts = {
            name: connection.scalar(select(func.count()).select_from(table(name))) or 0
            for name in (COUNTED if state == "current" else ())
        }
        revision = tables.revision(connection)
    return DatabaseState(database_name(database), state, revision, tables.head(), counts)


def _migrate(database: str, *, make: bool) -> tables.State:
    if not make:
        make_engine(database).dispose()  # says so when the file is missing
    name = sqlite_file(database_url(database))
    missing = name is not None and not os.path.exists(name)
    try:
        with (
            engine_of(database, migrates=True) as engine,
            engine.execution_options(writes=True).begin() as connection,
        ):
            before = tables.state(connection)
            if before == ("empty" if make else "old"):
                tables.upgrade(connection)
            elif before != "current":
                tables.require_current(connection)
    except BaseException:
        for end in ("", "-wal", "-shm", "-journal") if missing else ():
            with suppress(OSError):
                FilePath(f"{name}{end}").unlink()
        raise
    return before


TOOLS = {"postgresql": "pg_dump", "mysql": "mysqldump", "mariadb": "mariadb-dump"}


def backup(database: str, target: str | FilePath) -> None:
    """Copy `database`, which must be one of SQLite, to the new file `target`; refuse others."""
    copy = FilePath(target)
    if copy.exists():
        raise AvahazardError(
            f"{copy} is there already; nothing was written.", "Name a file that is not there."
        )
    url = database_url(database)
    file = sqlite_file(url)
    if file is None:
        backend = url.get_backend_name()
        raise AvahazardError(
            f"Only an SQLite database is copied here, and this is {backend}.",
            f"Use the database's own tool, such as {TOOLS.get(backend, 'its dump program')}.",
        )
    make_engine(database).dispose()  # says so when the file is missing
    try:
        with written_whole(copy) as part:
            part.open("xb").close()
            with closing(sqlite3.connect(file)) as source, closing(sqlite3.connect(part)) as sink:
                source.backup(sink)
                sink.execute("PRAGMA journal_mode = DELETE")  # the copy is one file
    except sqlite3.Error as error:
        raise AvahazardError(
            f"The database {file} could not be copied: {error}",
            "Look at it with `avahazard db check`.",
        ) from error


def check_database(session: Session) -> list[str]:
    """Return what is wrong: damaged pages, references to nothing, checksums that differ."""
    problems = []
    if session.get_bind().dialect.name == "sqlite":
        for (line,) in session.execute(text("PRAGMA integrity_check")):
            if line != "ok":
                problems.append(f"The file is damaged: {line}.")
        for name, row, parent, _ in session.execute(text("PRAGMA foreign_key_check")):
            problems.append(f"Row {row} of {name} refers to {parent} that is not there.")
    for calibration, model in session.execute(
        select(tables.CalibrationTable.id, tables.CalibrationTable.model)
    ):
        for fault in read_draws(session, calibration)[1]:
            problems.append(f"The draws of {model} (calibration {calibration}): {fault}.")
    for sealed in (
        tables.CalibrationTable,
        tables.ComparisonTable,
        tables.DiagnosisTable,
        tables.PathResultTable,
    ):
        problems += _faults(session, sealed)
    return problems


def _faults(session: Session, sealed: type[tables.Sealed]) -> Iterator[str]:
    for key in session.execute(select(*sealed.__table__.primary_key)).all():
        where = f"Row {', '.join(map(str, key))} of {sealed.__tablename__}"
        try:
            row = session.get_one(sealed, tuple(key))
        except ValueError:
            yield f"{where} is no document any more."
            continue
        if row.digest() != row.sha256:
            by = f", by {row.model}," if isinstance(row, tables.ResultTable) else ""
            yield f"{where}{by} is not what was stored: its checksum differs."
        session.expunge(row)
