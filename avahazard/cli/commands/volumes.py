"""`avahazard volumes`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import (
    DensityRatio,
    FamilyName,
    Frequency,
    Seed,
    Snowfall,
    Threshold,
    VolumeTable,
    picture,
    return_periods,
    volume_source,
)
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings
from avahazard.results.volumes import PathVolumes


def volumes(
    context: typer.Context,
    path: Annotated[
        list[str] | None,
        typer.Argument(metavar="[PATH]…", help="Paths; all without one.", show_default=False),
    ] = None,
    return_period: Annotated[
        list[float] | None,
        return_periods("May be given again. [default: 10, 30, 100, 300]"),
    ] = None,
    frequency: Frequency = FamilyName.gev,
    threshold: Threshold = None,
    table_file: VolumeTable = None,
    snowfall: Snowfall = None,
    density_ratio: DensityRatio = 0.5,
    plot: Annotated[Path | None, picture("Draw the return levels")] = None,
    seed: Seed = 0,
) -> None:
    """Fit how often which volumes come down the paths: return levels and their error.

    \b
    Examples:
      avahazard volumes
      avahazard volumes P01 -T 30 -T 100 --plot levels.png
      avahazard volumes --frequency gpd --threshold 20000
    """
    from avahazard.workflow.volumes import volumes as run  # noqa: PLC0415

    found = run(
        settings(context).database,
        paths=path or (),
        return_periods=return_period or (),
        source=volume_source(frequency, threshold, table_file, snowfall, density_ratio),
        seed=seed,
        plot=plot,
    )
    emit(context, found.rows, lambda console: _show(console, found.rows))
    warn(*found.notes)


def _show(console: Console, entries: Sequence[PathVolumes]) -> None:
    rows = []
    for entry in entries:
        name = entry.path_id
        for level in entry.levels:
            far = "*" if level.extrapolated else ""
            period = f"{level.return_period_years:g}{far}"
            interval = f"{_volume(level.q05_m3)}–{_volume(level.q95_m3)}"
            rows.append((name, period, _volume(level.volume_m3), interval))
            name = ""
    columns = ("path", ">T yr", ">V m3", ">5–95 % m3")
    console.print(table("Volumes of return periods, with 90 % of their posterior", columns, rows))
    for entry in entries:
        console.print(f"{entry.path_id}: {entry.method}.")
    if any(level.extrapolated for entry in entries for level in entry.levels):
        console.print("*: an extrapolation, past twice the record or past the table.")


def _volume(value: float) -> str:
    """A volume to three digits."""
    return f"{float(f'{value:.3g}'):.0f}" if value < 1e6 else f"{value:.3g}"
