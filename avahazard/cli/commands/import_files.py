"""`avahazard import`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings


def import_(
    context: typer.Context,
    source: Annotated[
        list[str], typer.Argument(help="CSV files, or folders of them.", show_default=False)
    ],
    update: Annotated[
        bool, typer.Option("--update", help="Replace stored rows that differ.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would happen, store nothing.")
    ] = False,
) -> None:
    """Import CSV files, or folders of them.

    All files are imported or none: every row that cannot be taken is listed.

    \b
    Examples:
      avahazard import my-records
      avahazard import events.csv velocities.csv --dry-run
      avahazard import events.csv --update
    """
    from avahazard.workflow.importing import import_files  # noqa: PLC0415

    document = import_files(settings(context).database, source, update=update, dry_run=dry_run)

    def render(console: Console) -> None:
        title = "Would be imported (nothing was stored)" if dry_run else "Imported"
        columns = ("", ">new", ">unchanged", ">updated")
        rows = [(kind, *count.values()) for kind, count in document["records"].items()]
        console.print(table(title, columns, rows))

    for note in document["notes"]:
        warn(note)
    emit(context, document, render)
