"""Making a database, bringing it up to date, and its state."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import Connection, func, select

from avahazard.store import schema
from avahazard.store.engine import database_name, make_engine
from avahazard.store.result_tables import CalibrationTable, ModelTable
from avahazard.store.session import translated
from avahazard.store.tables import Base, EventTable, PathTable, SpeedTable

COUNTED: dict[str, type[Base]] = {
    "paths": PathTable,
    "events": EventTable,
    "speeds": SpeedTable,
    "models": ModelTable,
    "calibrations": CalibrationTable,
}


@dataclass(frozen=True, slots=True)
class Status:
    """State of a schema, its revision and that of the program; counts when it is current."""

    database: str
    state: schema.State
    revision: str | None
    head: str | None
    counts: dict[str, int]


def create(database: str) -> schema.State:
    """Create the tables of an empty or missing `database`; return its state before.

    Raises:
        AvahazardError: it holds other tables, or cannot be written.
    """
    return _migrate(database, {"empty"}, make=True)


def upgrade(database: str) -> schema.State:
    """Run the migrations that `database` lacks; return its state before.

    Raises:
        AvahazardError: it is missing or empty, of another program, or newer than this one.
    """
    return _migrate(database, {"old"}, make=False)


def status(database: str) -> Status:
    """Return the state of `database`.

    Raises:
        AvahazardError: it is missing or cannot be read.
    """
    with translated(database):
        engine = make_engine(database)
        try:
            with engine.connect() as connection:
                state = schema.state(connection)
                counts = _counts(connection) if state == "current" else {}
                revision = schema.revision(connection)
        finally:
            engine.dispose()
    return Status(database_name(database), state, revision, schema.head(), counts)


def _migrate(database: str, wanted: set[schema.State], *, make: bool) -> schema.State:
    with translated(database):
        if not make:
            make_engine(database).dispose()  # says so when the file is missing
        engine = make_engine(database, migrates=True).execution_options(writes=True)
        try:
            with engine.begin() as connection:
                before = schema.state(connection)
                if before in wanted:
                    schema.upgrade(connection)
                elif before == "foreign" or (before != "current" and not make):
                    schema.require_current(connection)
        finally:
            engine.dispose()
    return before


def _counts(connection: Connection) -> dict[str, int]:
    return {
        name: connection.scalar(select(func.count()).select_from(table)) or 0
        for name, table in COUNTED.items()
    }
