"""`avahazard init`."""

from __future__ import annotations

import typer
from rich.console import Console

from avahazard.cli.output import emit, warn
from avahazard.cli.settings import settings


def init(context: typer.Context) -> None:
    """Create the database.

    \b
    Examples:
      avahazard init
      avahazard --db valley.db init
    """
    from avahazard.workflow.database import init_database  # noqa: PLC0415

    found = init_database(settings(context).database)

    def render(console: Console) -> None:
        done = "was created" if found.created else "exists"
        console.print(f"The database {found.database} {done}.", soft_wrap=True)

    emit(context, found, render)
    if found.state == "old":
        warn("it was made by an older version: run `avahazard db upgrade`.")
    elif found.state == "newer":
        warn("it was made by a newer version: update the program.")
