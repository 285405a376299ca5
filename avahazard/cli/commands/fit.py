"""`avahazard fit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import picture
from avahazard.cli.output import emit, number, table, warn
from avahazard.cli.settings import settings


def fit(
    context: typer.Context,
    path: Annotated[
        str | None,
        typer.Option(metavar="PATH", help="Only events of this path.", show_default=False),
    ] = None,
    plot: Annotated[Path | None, picture("Draw the laws on the points")] = None,
) -> None:
    """Fit laws of friction against volume by least squares.

    \b
    Examples:
      avahazard fit
      avahazard fit --path P01 --plot laws.png
    """
    from avahazard.inference.model.laws import LAWS  # noqa: PLC0415
    from avahazard.workflow.fit import fit_laws  # noqa: PLC0415

    found = fit_laws(settings(context).database, path, plot)

    def render(console: Console) -> None:
        rows = []
        for entry in found.rows:
            law, r2, aic = (
                LAWS[entry.law].formula,
                f"{round(entry.r2, 3) + 0.0:.3f}",
                f"{entry.aic:.1f}",
            )
            for name, parameter in entry.parameters.items():
                value = f"{number(parameter.value)} {parameter.unit}".rstrip()
                rows.append((law, name, value, parameter.se, r2, aic))
                law = r2 = aic = ""
        columns = ("law", "", ">value", ">± se", ">r²", ">AIC")
        console.print(table("Least squares of apparent friction", columns, rows))

    emit(context, found.rows, render)
    warn(*found.notes)
