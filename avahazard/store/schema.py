"""The schema of a database and its migrations."""

from __future__ import annotations

from importlib.resources import files
from typing import Literal

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, inspect

from avahazard.records.errors import AvahazardError

State = Literal["empty", "foreign", "old", "current", "newer"]


def state(connection: Connection) -> State:
    """Return how the schema of a database stands to that of this program.

    `foreign` holds tables but was not made by this program; `newer` has a revision that
    this program does not know.
    """
    current = revision(connection)
    if current is None:
        return "foreign" if inspect(connection).get_table_names() else "empty"
    script = ScriptDirectory.from_config(_config())
    if current == script.get_current_head():
        return "current"
    return "old" if current in {r.revision for r in script.walk_revisions()} else "newer"


def revision(connection: Connection) -> str | None:
    """Return the revision of a database, None where it has none."""
    return MigrationContext.configure(connection).get_current_revision()


def head() -> str | None:
    """Return the revision that this program works with."""
    return ScriptDirectory.from_config(_config()).get_current_head()


def require_current(connection: Connection) -> None:
    """Refuse a database whose schema is not that of this program.

    Raises:
        AvahazardError: with the command that mends it.
    """
    found = state(connection)
    if found == "current":
        return
    message, hint = {
        "empty": ("The database is empty.", "Create its tables with `avahazard init`."),
        "foreign": (
            "The database holds other tables, not those of avahazard.",
            "Name another database with --db.",
        ),
        "old": (
            "The database was made by an older version of avahazard.",
            "Bring it up to date with `avahazard db upgrade` (`avahazard db backup` first).",
        ),
        "newer": (
            "The database was made by a newer version of avahazard.",
            "Update the program: this version does not know its tables.",
        ),
    }[found]
    raise AvahazardError(message, hint)


def upgrade(connection: Connection) -> None:
    """Run the migrations that `connection`'s database lacks."""
    config = _config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _config() -> Config:
    config = Config()
    # A percent sign in the folder's name would be taken for an interpolation.
    folder = str(files("avahazard.migrations")).replace("%", "%%")
    config.set_main_option("script_location", folder)
    return config
