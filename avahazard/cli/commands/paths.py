"""`avahazard paths`."""

from __future__ import annotations

import typer
from rich.console import Console

from avahazard.cli.output import emit, table
from avahazard.cli.settings import settings


def paths(context: typer.Context) -> None:
    """List the paths.

    \b
    Examples:
      avahazard paths
      avahazard --json paths > paths.json
    """
    from avahazard.workflow.paths import list_paths  # noqa: PLC0415

    found = list_paths(settings(context).database)
    columns = (
        "path",
        "section",
        ">drop m",
        ">length m",
        ">events",
        ">left",
        ">V from m3",
        ">to m3",
    )

    def render(console: Console) -> None:
        if not found:
            console.print("There are no paths yet: import some.")
            return
        rows = [
            (
                row.path_id,
                row.section,
                row.drop_m,
                row.length_m,
                row.n_events,
                row.n_left_profile,
                row.volume_min_m3,
                row.volume_max_m3,
            )
            for row in found
        ]
        console.print(table("", columns, rows))

    emit(context, found, render)
