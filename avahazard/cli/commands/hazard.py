"""`avahazard hazard`."""

from __future__ import annotations

from typing import Annotated

import typer

from avahazard.cli.hazard_table import show_bounds
from avahazard.cli.options import (
    CalibratedModel,
    DensityRatio,
    EffectFiles,
    FamilyName,
    Frequency,
    OnlyPaths,
    Seed,
    Snowfall,
    Threshold,
    VolumeTable,
    return_periods,
    volume_source,
)
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


def hazard(
    context: typer.Context,
    name: CalibratedModel,
    return_period: Annotated[
        list[float] | None,
        return_periods("May be given again. [default: 100, where no volume is given]"),
    ] = None,
    volume: Annotated[
        list[float] | None,
        typer.Option("-V", "--volume", metavar="M3", help="May be given again."),
    ] = None,
    path: OnlyPaths = None,
    frequency: Frequency = FamilyName.gev,
    threshold: Threshold = None,
    volumes: VolumeTable = None,
    snowfall: Snowfall = None,
    density_ratio: DensityRatio = 0.5,
    draws: Annotated[int, typer.Option(min=100, max=10_000_000, help="For each row.")] = 20_000,
    seed: Seed = 0,
    effect_file: EffectFiles = None,
) -> None:
    """Give the design runout of return periods, and the runout of volumes, path by path.

    The design runout is exceeded once in the period, by avalanches of all volumes at the rate of
    the path. Below it stands where avalanches of the volume of that period stop.

    \b
    Examples:
      avahazard hazard first
      avahazard hazard first -T 30 -T 300 --path P01
      avahazard hazard first -T 100 --frequency gpd
      avahazard hazard first -T 100 --volumes volumes.csv
      avahazard --json hazard first -V 20000 > bounds.json
    """
    from avahazard.workflow.hazard import hazard as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            return_periods=return_period or (),
            volumes=volume or (),
            paths=path or (),
            source=volume_source(frequency, threshold, volumes, snowfall, density_ratio),
            n_draws=draws,
            seed=seed,
            effect_files=effect_file or (),
            report=report,
        )
    emit(context, found.rows, lambda console: show_bounds(console, found.rows))
    for note in found.notes:
        warn(note)
