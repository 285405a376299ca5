"""Sessions: one transaction each, for reading or for writing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy.exc import DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.store.engine import database_name, database_url, make_engine, sqlite_file
from avahazard.store.schema import require_current

__all__ = ["Session", "reading", "translated", "writing"]


@contextmanager
def reading(database: str) -> Iterator[Session]:
    """Open `database` for reading: a consistent view, nothing is written.

    Raises:
        AvahazardError: it is missing, of another schema, or cannot be read.
    """
    with _session(database, writes=False) as session:
        yield session


@contextmanager
def writing(database: str) -> Iterator[Session]:
    """Open `database` for writing: all is stored at the end, or nothing after an error.

    Other writers wait meanwhile: compute first, then open.

    Raises:
        AvahazardError: it is missing, of another schema, or cannot be written.
    """
    with _session(database, writes=True) as session:
        yield session
        session.commit()


def database_file(database: str) -> Path | None:
    """The file of a database, None for one on a server."""
    name = sqlite_file(database_url(database))
    return None if name is None else Path(name).absolute()


@contextmanager
def _session(database: str, *, writes: bool) -> Iterator[Session]:
    with translated(database):
        engine = make_engine(database)
        try:
            with engine.connect() as connection:
                require_current(connection)
            bind = engine.execution_options(writes=writes)
            with Session(bind) as session:
                yield session
        finally:
            engine.dispose()


@contextmanager
def translated(database: str) -> Iterator[None]:
    """Turn what the database refuses into one message."""
    try:
        yield
    except IntegrityError as error:
        raise AvahazardError(
            f"The database {database_name(database)} refuses this: {_first_line(error.orig)}",
            "Somebody may have written to it at the same moment: try again.",
        ) from error
    except DBAPIError as error:
        raise AvahazardError(
            f"The database {database_name(database)} does not answer: {_first_line(error.orig)}",
            _hint(str(error.orig)),
        ) from error
    except SQLAlchemyError as error:
        raise AvahazardError(
            f"The database {database_name(database)} cannot be used: {_first_line(error)}",
            "Look at it with `avahazard db check`.",
        ) from error


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


def _first_line(error: object) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
