"""A consistent copy of an SQLite database while others use it."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError
from avahazard.store.engine import database_url, make_engine, sqlite_file
from avahazard.whole_file import put_new_in_place

MOST_COPIES = 99
TOOLS = {"postgresql": "pg_dump", "mysql": "mysqldump", "mariadb": "mariadb-dump"}


def backup_beside(database: str, name: str) -> str:
    """Copy an SQLite database to the file `name`, or with a number after it, if that is there.

    Raises:
        AvahazardError: the copy cannot be made.
    """
    with _copied(database, FilePath(name)) as part:
        for number in range(1, MOST_COPIES + 1):
            file = name if number == 1 else f"{name}-{number}"
            with suppress(FileExistsError):
                put_new_in_place(part, FilePath(file))
                return file
    raise AvahazardError(f"There are {MOST_COPIES} copies {name} already.", "Remove old ones.")


def backup(database: str, target: str | FilePath) -> None:
    """Copy `database` to the new file `target`.

    Raises:
        AvahazardError: it is no SQLite database or missing, or `target` is there already.
    """
    copy = FilePath(target)
    there = AvahazardError(
        f"{copy} is there already; nothing was written.", "Name a file that is not there."
    )
    if copy.exists():
        raise there
    with _copied(database, copy) as part:
        try:
            put_new_in_place(part, copy)
        except FileExistsError:
            raise there from None


@contextmanager
def _copied(database: str, target: FilePath) -> Iterator[FilePath]:
    """A whole copy of `database` beside `target`, under a name that none takes for a copy."""
    url = database_url(database)
    file = sqlite_file(url)
    if file is None:
        backend = url.get_backend_name()
        raise AvahazardError(
            f"Only an SQLite database is copied here, and this is {backend}.",
            f"Use the database's own tool, such as {TOOLS.get(backend, 'its dump program')}.",
        )
    make_engine(database).dispose()  # says so when the file is missing
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    part.unlink(missing_ok=True)  # of a process that was killed
    try:
        part.open("xb").close()
        with closing(sqlite3.connect(file)) as source, closing(sqlite3.connect(part)) as sink:
            source.backup(sink)
            sink.execute("PRAGMA journal_mode = DELETE")  # the copy is one file
        yield part
    except sqlite3.Error as error:
        raise AvahazardError(
            f"The database {file} could not be copied: {error}",
            "Look at it with `avahazard db check`.",
        ) from error
    except OSError as error:
        error.filename = str(target)  # the name that was asked for
        raise
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
