"""`avahazard alpha-beta`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import picture
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings
from avahazard.results.terrain import TerrainRunout


def alpha_beta(
    context: typer.Context,
    path: Annotated[
        str | None,
        typer.Argument(help="The path_id of a path; all where none is given.", show_default=False),
    ] = None,
    by: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="norway, austria, avaframe or avaframe-small; may be given several times. "
            "[default: norway, austria]",
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Show the latest bounds by this model in the picture too."
        ),
    ] = None,
    plot: Annotated[Path | None, picture()] = None,
) -> None:
    """Give the alpha-beta runout of the paths: a baseline from the terrain alone.

    \b
    Examples:
      avahazard alpha-beta P01
      avahazard alpha-beta --by austria --by avaframe
      avahazard alpha-beta --plot baseline.png --model first
    """
    if model is not None and plot is None:
        raise typer.BadParameter("A --model is shown in a picture only: give --plot FILE.")
    from avahazard.workflow.alpha_beta import alpha_beta_paths  # noqa: PLC0415

    rows = alpha_beta_paths(settings(context).database, path, by=by or (), model=model, plot=plot)

    def render(console: Console) -> None:
        console.print(
            table(
                "Extreme runout by regression on the terrain (α-β)",
                ("path", "by", ">β °", ">β at x m", ">α °", ">sd °", ">x m", ">x ± 1 sd m"),
                [_cells(row) for row in rows],
            )
        )
        for name, source in {row.coefficients: row.source for row in rows}.items():
            console.print(f"{name}: {source}.")
        if any("beyond" in cell for row in rows for cell in _cells(row)):
            console.print("beyond: the line at α meets no ground before the profile ends.")

    emit(context, rows, render)
    warn(*dict.fromkeys(note for row in rows for note in row.notes))


def _cells(row: TerrainRunout) -> tuple[str, ...]:
    if row.beta_deg is None or row.beta_x_m is None or row.alpha_deg is None:
        return (row.path_id, row.coefficients, *["–"] * 6)
    return (
        row.path_id,
        row.coefficients,
        f"{row.beta_deg:.1f}",
        f"{row.beta_x_m:.0f}",
        f"{row.alpha_deg:.1f}",
        f"{row.alpha_sd_deg:g}",
        _place(row.runout_x_m),
        f"{_place(row.runout_x_low_m)}–{_place(row.runout_x_high_m)}",
    )


def _place(x: float | None) -> str:
    return "beyond" if x is None else f"{x:.0f}"
