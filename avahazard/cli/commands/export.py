"""`avahazard export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import output_file
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings


def export(
    context: typer.Context,
    name: Annotated[
        str, typer.Argument(help="A model with bounds by `hazard`.", show_default=False)
    ],
    output: Annotated[
        Path,
        output_file(
            "Ends in .gpkg, .geojson, .csv, .xlsx or .parquet. An export that is there is replaced."
        ),
    ],
) -> None:
    """Write the bounds and zones of a model for a GIS or a spreadsheet.

    \b
    Examples:
      avahazard export first -o first.gpkg
      avahazard export first -o first.geojson
      avahazard export first -o first.csv
      avahazard export first -o first.xlsx
      avahazard export first -o first.parquet
    """
    from avahazard.workflow.export import export as run  # noqa: PLC0415

    found = run(settings(context).database, name, output)

    def render(console: Console) -> None:
        rows = [(x.layer, x.n_features, x.crs) for x in found.layers]
        console.print(table(found.file, ("layer", ">features", "crs"), rows))

    warn(*found.notes)
    emit(context, found, render)
