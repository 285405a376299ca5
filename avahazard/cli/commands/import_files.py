"""`avahazard import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings


def import_(
    context: typer.Context,
    source: Annotated[
        list[str],
        typer.Argument(
            help="CSV files or folders of them; lines as .gpkg, .geojson or .shp.",
            show_default=False,
        ),
    ],
    dem: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The terrain model under the lines: .tif or .asc."),
    ] = None,
    land_cover: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Polygons with an attribute land_cover."),
    ] = None,
    update: Annotated[
        bool, typer.Option("--update", help="Replace stored rows that differ.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would happen, store nothing.")
    ] = False,
) -> None:
    """Import CSV files, or folders of them, or paths drawn as lines on a terrain model.

    Each line is a path, drawn from its top; its attributes are the columns of paths.csv.
    All files are imported or none: every row that cannot be taken is listed.

    \b
    Examples:
      avahazard import my-records
      avahazard import events.csv velocities.csv --dry-run
      avahazard import events.csv --update
      avahazard import lines.gpkg events.csv --dem terrain.tif --land-cover forest.gpkg
    """
    from avahazard.workflow.import_files import import_files  # noqa: PLC0415

    found = import_files(
        settings(context).database,
        source,
        dem=dem,
        land_cover=land_cover,
        update=update,
        dry_run=dry_run,
    )

    def render(console: Console) -> None:
        title = "Would be imported (nothing was stored)" if dry_run else "Imported"
        columns = ("", ">new", ">unchanged", ">updated")
        rows = [(kind, *counts.values()) for kind, counts in found.records.to_dict().items()]
        console.print(table(title, columns, rows))

    for note in found.notes:
        warn(note)
    emit(context, found, render)
