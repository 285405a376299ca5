"""The database itself: made, brought up to date, looked at, checked, copied."""

from __future__ import annotations

from dataclasses import asdict

from avahazard.results.database import Checked, Copied, Created, DatabaseState, Upgraded
from avahazard.store import upkeep
from avahazard.store.backup import backup
from avahazard.store.check import check_database
from avahazard.store.engine import database_name
from avahazard.store.session import reading


def init_database(database: str) -> Created:
    """Create the tables of `database`; `created` is false where it exists.

    Raises:
        AvahazardError: it holds other tables, or cannot be written.
    """
    before = upkeep.create(database)
    created = before == "empty"
    return Created(database_name(database), created, "current" if created else before)


def upgrade_database(database: str) -> Upgraded:
    """Run the migrations that `database` lacks.

    Raises:
        AvahazardError: it is missing, empty, of another program, or newer than this one.
    """
    before = upkeep.status(database).revision
    upkeep.upgrade(database)
    after = upkeep.status(database)
    return Upgraded(after.database, before, after.revision)


def database_status(database: str) -> DatabaseState:
    """Return the state of the schema of `database`, its revision and its counts.

    Raises:
        AvahazardError: it is missing or cannot be read.
    """
    return DatabaseState(**asdict(upkeep.status(database)))


def check(database: str) -> Checked:
    """Return whether `database` is whole, and the list of its problems.

    Raises:
        AvahazardError: it is missing, of another schema, or cannot be read at all.
    """
    with reading(database) as session:
        problems = check_database(session)
    return Checked(database_name(database), not problems, tuple(problems))


def backup_database(database: str, target: str) -> Copied:
    """Copy an SQLite `database` to the new file `target`, also while it is used.

    Raises:
        AvahazardError: it is not SQLite or missing, or `target` is there already.
    """
    backup(database, target)
    return Copied(database_name(database), target)
