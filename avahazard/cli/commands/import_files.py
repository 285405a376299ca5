"""`avahazard import`."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, errors, table, warn
from avahazard.cli.settings import settings
from avahazard.records.conventions import Decimal, Order


def import_(
    context: typer.Context,
    source: Annotated[
        list[str],
        typer.Argument(
            help="Tables (.csv, .xlsx) or folders of them; lines as .gpkg, .geojson or .shp.",
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
    crs: Annotated[
        str | None,
        typer.Option(
            metavar="CODE",
            help="The system of a terrain model that names none, such as EPSG:31287. [default: "
            "that of the lines]",
            show_default=False,
        ),
    ] = None,
    update: Annotated[
        bool, typer.Option("--update", help="Replace stored rows that differ.")
    ] = False,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run", help="Say how the files are read and what would happen, store nothing."
        ),
    ] = False,
    unusual: Annotated[
        bool,
        typer.Option(
            "--unusual", help="Numbers beyond those of snow avalanches are meant so: no note."
        ),
    ] = False,
    decimal: Annotated[
        Decimal | None,
        typer.Option(help="The decimal sign, where a file does not show it.", show_default=False),
    ] = None,
    dates: Annotated[
        Order | None,
        typer.Option(help="Day or month first, where dates do not show it.", show_default=False),
    ] = None,
) -> None:
    """Import tables, or folders of them, or paths drawn as lines on a terrain model.

    Tables are workbooks (.xlsx) or texts with commas, semicolons or tabs; how each was read is
    said. What may be read in two ways is refused until --decimal or --dates says it.
    Each line is a path, drawn from its top; its attributes are the columns of paths.csv.
    All files are imported or none: every row that cannot be taken is listed.

    \b
    Examples:
      avahazard import my-records
      avahazard import events.csv velocities.csv --dry-run
      avahazard import records.xlsx --dry-run
      avahazard import events.csv --dates dmy --update
      avahazard import slides.csv --unusual
      avahazard import lines.gpkg events.csv --dem terrain.tif --land-cover forest.gpkg
    """
    from avahazard.records.conventions import Conventions  # noqa: PLC0415
    from avahazard.workflow.import_files import import_files  # noqa: PLC0415

    found = import_files(
        settings(context).database,
        source,
        dem=dem,
        land_cover=land_cover,
        crs=crs,
        update=update,
        dry_run=dry_run,
        given=Conventions(decimal, dates, unusual),
    )

    def render(console: Console) -> None:
        if dry_run:
            headings = ("column", "meaning", "unit", "first values")
            for (file, form), read in groupby(found.understood, lambda c: (c.file, c.form)):
                cells = [(c.column, c.meaning, c.unit, ", ".join(c.values)) for c in read]
                console.print(table(f"{file}: {form}", headings, cells))
        title = "Would be imported (nothing was stored)" if dry_run else "Imported"
        columns = ("", ">new", ">unchanged", ">updated")
        rows = [(kind, *counts.values()) for kind, counts in found.records.to_dict().items()]
        console.print(table(title, columns, rows))

    for line in found.read:
        errors().print(f"Read {line}.", soft_wrap=True)
    warn(*found.notes)
    emit(context, found, render)
