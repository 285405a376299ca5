"""The connection to a database (SQLite by a plain path, any other by its URL) and its sessions."""

import json
import os
import sqlite3
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path as FilePath
from sqlite3 import Connection as SqliteConnection
from threading import Timer
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

from avahazard.records.errors import AvahazardError
from avahazard.store.tables import require_current

__all__ = [
    "Session",
    "database_name",
    "database_url",
    "reading",
    "require_writable",
    "sqlite_file",
    "writing",
]

MIGRATION_LOCK = 7_244_306
"""Any number that other programs on one server hardly take."""
LONGEST_PATH = 500
BUSY_TIMEOUT_S, SILENT_S = 600, 5.0
"""A writer waits for the others, each of which may import a century's records, and says so soon."""


def database_url(database: str) -> URL:
    """Return the URL of `database`, one itself or the path of an SQLite file; refuse others."""
    if "://" not in database:
        return URL.create("sqlite", database=database)
    try:
        return make_url(database)
    except (ArgumentError, ValueError) as error:
        raise AvahazardError(
            f"{database.rsplit('@', maxsplit=1)[-1]} is not the URL of a database.",
            "Give a file path, or a URL such as postgresql+psycopg://user@host/name.",
        ) from error


def database_name(database: str) -> str:
    """Return how to show `database` to people: without its password."""
    url = database_url(database)
    return sqlite_file(url) or url.render_as_string(hide_password=True)


def sqlite_file(url: URL) -> str | None:
    """Return the file of an SQLite database, None for another database."""
    return (url.database or None) if url.get_backend_name() == "sqlite" else None


def make_engine(database: str, *, migrates: bool = False) -> Engine:
    """Return an engine for `database`; it connects when it is used.

    Writers come one after the other: on SQLite by its lock, for which they wait up to 10 minutes,
    on PostgreSQL by a lock on the table of the revision, taken before anything is read. SQLite
    keeps a write-ahead log, synced at every commit, and foreign keys on; from a folder that cannot
    be written to it is read as it stands. A migration may create the file, and has the foreign keys
    off: it changes a table by copying it, and dropping the old one would take its children along.
    Raises `AvahazardError` where the driver is missing, or the file of an SQLite database is.
    """
    url = database_url(database)
    sqlite = url.get_backend_name() == "sqlite"
    writer = partial(json.dumps, ensure_ascii=False, allow_nan=False)
    options: dict[str, Any] = {"json_serializer": writer}
    frozen = False
    if sqlite:
        file = _checked_file(url, migrates)
        options["connect_args"] = {"timeout": BUSY_TIMEOUT_S}
        frozen = not migrates and _is_frozen(file)
        if frozen:
            address = f"{file.absolute().as_uri()}?mode=ro&immutable=1"
            options["creator"] = partial(sqlite3.connect, address, uri=True)
    else:
        # Every transaction sees one state of the data; SQLite has it so anyway.
        # A migration looks at the schema after it has waited for others, so it sees what they did.
        options["isolation_level"] = "READ COMMITTED" if migrates else "REPEATABLE READ"
    try:
        engine = create_engine(url, **options)
    except (ArgumentError, ImportError) as error:
        raise AvahazardError(
            f"There is no driver for {url.drivername}: {error}",
            "Install the driver of the database, for PostgreSQL: pip install psycopg[binary]",
        ) from error
    if sqlite:
        set_up = partial(_set_up_sqlite, foreign_keys=not migrates, frozen=frozen)
        event.listen(engine, "connect", set_up)
        event.listen(engine, "begin", _begin_sqlite)
    elif url.get_backend_name() == "postgresql":
        event.listen(engine, "begin", _wait_to_migrate if migrates else _begin_postgresql)
    return engine


def _is_frozen(file: FilePath) -> bool:
    """Whether an SQLite file lies in a folder that nobody can write to, with nothing in its log.

    SQLite would have to make the files of the log to read it in the common way.
    """
    log = file.with_name(f"{file.name}-wal")
    unwritten = not log.exists() or log.stat().st_size == 0
    return unwritten and not can_write(file.absolute().parent)


def can_write(place: FilePath) -> bool:
    """Whether this process may write a file, or into a folder."""
    return os.access(place, os.W_OK)


def _checked_file(url: URL, create: bool) -> FilePath:
    name = sqlite_file(url)
    if name is None or name == ":memory:":
        raise AvahazardError(
            "The database has no file.", "Give --db a file path: a database has to be kept."
        )
    file = FilePath(name)
    # SQLite's limit, and room for the names of its log beside it.
    if len(os.fsencode(file.absolute())) > LONGEST_PATH or len(os.fsencode(file.name)) > 250:
        raise AvahazardError(
            f"The path of the database is too long: {len(os.fsencode(file.absolute()))} bytes.",
            f"Use a path of at most {LONGEST_PATH} bytes, with a file name of at most 250.",
        )
    if file.is_dir():
        raise AvahazardError(f"{file} is a folder, not a database.", "Give --db a file path.")
    if create and not file.absolute().parent.is_dir():
        raise AvahazardError(
            f"There is no folder {file.parent} for the database.", "Make the folder first."
        )
    if not create and not file.exists():
        raise AvahazardError(
            f"There is no database {file}.",
            "Create it with `avahazard init`, or name another one with --db.",
        )
    return file


def _set_up_sqlite(
    connection: SqliteConnection, _: ConnectionPoolEntry, *, foreign_keys: bool, frozen: bool
) -> None:
    # The driver would begin transactions by itself, and late: they begin in _begin_sqlite.
    connection.isolation_level = None
    connection.execute(f"PRAGMA foreign_keys = {'ON' if foreign_keys else 'OFF'}")
    if frozen:
        return
    connection.execute("PRAGMA journal_mode = WAL")
    # What was confirmed is there after a power cut, also while others hold the file.
    connection.execute("PRAGMA synchronous = FULL")


def _begin_sqlite(connection: Connection) -> None:
    # A writer takes the lock at once: one that reads first would be refused when it writes.
    if not connection.get_execution_options().get("writes", False):
        connection.exec_driver_sql("BEGIN")
        return
    waiting = "The database is in use by another program: waiting until it is free."
    said = Timer(SILENT_S, partial(print, waiting, file=sys.stderr))
    said.start()
    try:
        connection.exec_driver_sql("BEGIN IMMEDIATE")
    finally:
        said.cancel()


def _begin_postgresql(connection: Connection) -> None:
    # A lock is no query: the view of the data begins with the first statement after it, so that
    # a writer never works on what another has changed meanwhile. Readers pass.
    if connection.get_execution_options().get("writes", False):
        connection.exec_driver_sql("LOCK TABLE alembic_version IN EXCLUSIVE MODE")


def _wait_to_migrate(connection: Connection) -> None:
    connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({MIGRATION_LOCK})")


def reading(database: str) -> AbstractContextManager[Session]:
    """Open `database` for a consistent view; refused where it is missing or of another schema."""
    return _session(database, writes=False)


@contextmanager
def writing(database: str) -> Iterator[Session]:
    """Open `database` for writing: all is stored at the end, or nothing after an error.

    Other writers wait meanwhile: compute first, then open. Raises `AvahazardError` where it is
    missing, of another schema, or cannot be written.
    """
    with _session(database, writes=True) as session:
        yield session
        session.commit()


def require_writable(database: str) -> None:
    """Refuse a database that cannot be written, before what is to be stored takes minutes."""
    file = sqlite_file(database_url(database))
    if file is None or not FilePath(file).exists():
        return
    if not (can_write(FilePath(file)) and can_write(FilePath(file).absolute().parent)):
        raise AvahazardError(
            f"The database {file} cannot be written.",
            "Look at the permissions of the file and of its folder.",
        )


@contextmanager
def _session(database: str, *, writes: bool) -> Iterator[Session]:
    with engine_of(database) as engine:
        with engine.connect() as connection:
            require_current(connection)
        with Session(engine.execution_options(writes=writes)) as session:
            yield session


@contextmanager
def engine_of(database: str, *, migrates: bool = False) -> Iterator[Engine]:
    """The engine of a database (`make_engine`) as long as it is used; it refuses in one message."""
    engine = make_engine(database, migrates=migrates)
    try:
        yield engine
    except SQLAlchemyError as error:
        reason = error.orig if isinstance(error, DBAPIError) else error
        does, hint = "cannot be used", "Look at it with `avahazard db check`."
        if isinstance(error, IntegrityError):
            does = "refuses this"
            hint = "Somebody may have written to it at the same moment: try again."
        elif isinstance(error, DBAPIError):
            does, hint = "does not answer", _hint(str(reason))
        first = next(iter(str(reason).strip().splitlines()), type(reason).__name__)
        message = f"The database {database_name(database)} {does}: {first}"
        raise AvahazardError(message, hint) from error
    finally:
        engine.dispose()


def _hint(reason: str) -> str:
    if "not a database" in reason or "malformed" in reason:
        return "The file is damaged or of another kind: name another one with --db, or a backup."
    if "disk is full" in reason or "No space left" in reason or "could not extend" in reason:
        return "The disk is full: nothing of this was stored. Make room, and do it again."
    if "locked" in reason:
        return "Another program writes to it: try again when it is done."
    if "readonly" in reason or "unable to open" in reason:
        return "Look at the permissions of the file and of its folder."
    return "Look whether the database is there and you may use it."
