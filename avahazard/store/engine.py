"""The connection to a database: SQLite by a plain path, any other by its URL."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path as FilePath
from sqlite3 import Connection as SqliteConnection
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError
from sqlalchemy.pool import ConnectionPoolEntry

from avahazard.records.errors import AvahazardError

BUSY_TIMEOUT_S = 30


def database_url(database: str) -> URL:
    """Return the URL of `database`, which is a URL already or the path of an SQLite file.

    Raises:
        AvahazardError: `database` looks like a URL but is none.
    """
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

    SQLite keeps a write-ahead log, foreign keys on, and waits up to 30 s for a writer. A
    migration may create the file, and has the foreign keys off: it changes a table by
    copying it, and dropping the old one would take its children along.

    Raises:
        AvahazardError: the driver is missing, or the file of an SQLite database is.
    """
    url = database_url(database)
    sqlite = url.get_backend_name() == "sqlite"
    if sqlite:
        _check_file(url, migrates)
    # Every transaction sees one state of the data; SQLite has it so anyway.
    options: dict[str, Any] = (
        {"connect_args": {"timeout": BUSY_TIMEOUT_S}}
        if sqlite
        else {"isolation_level": "REPEATABLE READ"}
    )
    writer = partial(json.dumps, ensure_ascii=False, allow_nan=False)
    try:
        engine = create_engine(url, json_serializer=writer, **options)
    except (ArgumentError, ImportError) as error:
        raise AvahazardError(
            f"There is no driver for {url.drivername}: {error}",
            "Install the driver of the database, for PostgreSQL: pip install psycopg[binary]",
        ) from error
    if sqlite:
        event.listen(engine, "connect", partial(_set_up_sqlite, foreign_keys=not migrates))
        event.listen(engine, "begin", _begin_sqlite)
    return engine


def _check_file(url: URL, create: bool) -> None:
    name = sqlite_file(url)
    if name is None or name == ":memory:":
        raise AvahazardError(
            "The database has no file.", "Give --db a file path: a database has to be kept."
        )
    file = FilePath(name)
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


def _set_up_sqlite(
    connection: SqliteConnection, _: ConnectionPoolEntry, *, foreign_keys: bool
) -> None:
    # The driver would begin transactions by itself, and late: they begin in _begin_sqlite.
    connection.isolation_level = None
    connection.execute(f"PRAGMA foreign_keys = {'ON' if foreign_keys else 'OFF'}")
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = NORMAL")


def _begin_sqlite(connection: Connection) -> None:
    # A writer takes the lock at once: one that reads first would be refused when it writes.
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
