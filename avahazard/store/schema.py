"""The schema of a database and its migrations."""

from __future__ import annotations

import re
from importlib.resources import files
from typing import TYPE_CHECKING, Literal

from sqlalchemy import Connection, inspect, text

from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    from alembic.config import Config

State = Literal["empty", "foreign", "old", "current", "newer"]
_REVISION = re.compile(r"^(revision|down_revision) = (?:None|[\"'](.+)[\"'])$", re.MULTILINE)


def state(connection: Connection) -> State:
    """Return how the schema of a database stands to that of this program.

    `foreign` holds tables but was not made by this program; `newer` has a revision that
    this program does not know.
    """
    current = revision(connection)
    if current is None:
        return "foreign" if inspect(connection).get_table_names() else "empty"
    if current == head():
        return "current"
    return "old" if current in _revisions() else "newer"


def revision(connection: Connection) -> str | None:
    """Return the revision of a database, None where it has none."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    found: str | None = connection.scalar(text("SELECT version_num FROM alembic_version"))
    return found


def head() -> str | None:
    """Return the revision that this program works with."""
    revisions = _revisions()
    return next((name for name in revisions if name not in revisions.values()), None)


def _revisions() -> dict[str, str | None]:
    """Each revision and the one before it, read off the migrations' files.

    Alembic would run them all, and takes longer to load than most commands to run.
    """
    found: dict[str, str | None] = {}
    for file in (files("avahazard.migrations") / "versions").iterdir():
        if file.name.endswith(".py"):
            names = dict(_REVISION.findall(file.read_text(encoding="utf-8")))
            if names.get("revision"):
                found[names["revision"]] = names.get("down_revision") or None
    return found


def require_current(connection: Connection) -> None:
    """Refuse a database whose schema is not that of this program.

    Raises `AvahazardError` with the command that mends it.
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
    from alembic import command  # noqa: PLC0415 (slow, and rarely needed)

    config = _config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _config() -> Config:
    from alembic.config import Config  # noqa: PLC0415 (slow, and rarely needed)

    config = Config()
    # A percent sign in the folder's name would be taken for an interpolation.
    folder = str(files("avahazard.migrations")).replace("%", "%%")
    config.set_main_option("script_location", folder)
    return config
