"""A consistent copy of an SQLite database while others use it."""

from __future__ import annotations

import sqlite3
from contextlib import closing, suppress
from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError
from avahazard.store.engine import database_url, make_engine, sqlite_file

MOST_COPIES = 99
TOOLS = {"postgresql": "pg_dump", "mysql": "mysqldump", "mariadb": "mariadb-dump"}


def backup_beside(database: str, name: str) -> str:
    """Copy an SQLite database to the file `name`, or with a number after it, if that is there.

    Raises:
        AvahazardError: the copy cannot be made.
    """
    for number in range(1, MOST_COPIES + 1):
        file = name if number == 1 else f"{name}-{number}"
        if not FilePath(file).exists():
            backup(database, file)
            return file
    raise AvahazardError(f"There are {MOST_COPIES} copies {name} already.", "Remove old ones.")


def backup(database: str, target: str | FilePath) -> None:
    """Copy `database` to the new file `target`.

    Raises:
        AvahazardError: it is no SQLite database or missing, or `target` is there already.
    """
    url = database_url(database)
    file = sqlite_file(url)
    if file is None:
        backend = url.get_backend_name()
        raise AvahazardError(
            f"Only an SQLite database is copied here, and this is {backend}.",
            f"Use the database's own tool, such as {TOOLS.get(backend, 'its dump program')}.",
        )
    make_engine(database).dispose()  # says so when the file is missing
    copy = FilePath(target)
    try:
        copy.open("xb").close()
    except FileExistsError:
        raise AvahazardError(
            f"{copy} is there already; nothing was written.", "Name a file that is not there."
        ) from None
    try:
        with closing(sqlite3.connect(file)) as source, closing(sqlite3.connect(copy)) as sink:
            source.backup(sink)
            sink.execute("PRAGMA journal_mode = DELETE")  # the copy is one file
    except sqlite3.Error as error:
        with suppress(OSError):
            copy.unlink()
        raise AvahazardError(
            f"The database {file} could not be copied: {error}",
            "Look at it with `avahazard db check`.",
        ) from error
