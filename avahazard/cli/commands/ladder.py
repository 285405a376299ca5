"""`avahazard ladder`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import COORDINATES, crps_words
from avahazard.cli.options import picture
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.records.plain import plain
from avahazard.results.amounts import amount, bare, unit_of


def ladder(
    context: typer.Context,
    plot: Annotated[Path | None, picture("Draw the held-out error and the error budgets")] = None,
) -> None:
    """List every model and its error, oldest first.

    \b
    Examples:
      avahazard ladder
      avahazard ladder --plot ladder.png
    """
    from avahazard.workflow.ladder import ladder as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, plot=plot, report=report)
    extra = ("noise_floor_m", "noise_floor_crps_m")
    document = [{k: v for k, v in row.items() if k not in extra} for row in plain(found.rows)]

    def render(console: Console) -> None:
        cells = [
            (
                row.model,
                row.parent,
                ", ".join(row.added) or None,
                _error(row.held_out_crps_m, row.coordinate),
                _error(row.held_out_crps_x_m, "x"),
                _error(row.crps_m, row.coordinate),
                None if row.elpd_loo is None else f"{row.elpd_loo:.0f}",
                None if row.coverage_90 is None else f"{row.coverage_90:.0%}",
                row.speed_rmse_m_s,
            )
            for row in found.rows
        ]
        coordinates = {row.coordinate for row in found.rows if row.coordinate is not None}
        coordinate = next(iter(coordinates)) if len(coordinates) == 1 else None
        unit = unit_of(coordinate)
        columns = (
            "model", "parent", "added", f">error {unit}", ">in x m", f">own {unit}", ">elpd",
            ">in 90 %", ">m/s",
        )  # fmt: skip
        console.print(table("Every model and its error", columns, cells))
        of = {COORDINATES[known] for known in coordinates}
        console.print(
            f"error: CRPS where held out, of {' or '.join(sorted(of))}; in x: the same of the "
            "distance along the path; own: on the records that the model was calibrated on, as "
            "the share in 90 % and the speeds (RMSE, m/s) are."
        )
        console.print(crps_words(coordinate))
        floors = [row.noise_floor_crps_m for row in found.rows if row.noise_floor_crps_m]
        if floors:
            # What the error of a volume does to a stop is the model's own; gibbs knows none.
            low, high = (amount(floor, coordinate) for floor in (min(floors), max(floors)))
            console.print(
                f"Errors of the records alone (runout, volume, release) would leave "
                f"{low if low == high else f'{low} to {high}, by model'}; what varies from "
                "avalanche to avalanche comes on top."
            )

    emit(context, document, render)
    warn(*found.notes)


def _error(value: float | None, coordinate: str | None) -> str | None:
    return None if value is None else bare(value, coordinate, 0)
