"""`avahazard effects`."""

from __future__ import annotations

import typer
from rich.console import Console

from avahazard.cli.output import emit, table
from avahazard.cli.settings import settings


def effects(context: typer.Context) -> None:
    """List the effects that a model can have, and whether the present data can tell them.

    \b
    Example:
      avahazard effects
    """
    from avahazard.workflow.effects import list_effects  # noqa: PLC0415

    found = list_effects(settings(context).database)

    def render(console: Console) -> None:
        cells = [
            (row.key, row.needs, "yes" if row.lacking is None else f"no: {row.lacking}")
            for row in found
        ]
        columns = ("effect", "needs", "can these data tell?")
        console.print(table("Effects", columns, cells))
        console.print("More on one: avahazard effect KEY. Your own: avahazard effect new FILE.")

    emit(context, found, render)
