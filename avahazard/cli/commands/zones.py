"""`avahazard zones`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
    picture,
    return_periods,
    volume_source,
)
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.cli.zones_table import show_zones


def zones(
    context: typer.Context,
    name: CalibratedModel,
    return_period: Annotated[
        list[float] | None,
        return_periods("Besides those of the limits; may be given again."),
    ] = None,
    limits: Annotated[
        str,
        typer.Option(metavar="LIMITS", help="swiss, french, or a TOML file of your own."),
    ] = "swiss",
    path: OnlyPaths = None,
    frequency: Frequency = FamilyName.gev,
    threshold: Threshold = None,
    volumes: VolumeTable = None,
    snowfall: Snowfall = None,
    density_ratio: DensityRatio = 0.5,
    density: Annotated[float, typer.Option(metavar="KG_M3", help="Of the flow, its mean.")] = 300.0,
    density_sd: Annotated[
        float, typer.Option(metavar="KG_M3", help="Standard deviation of the density.")
    ] = 50.0,
    plot: Annotated[Path | None, picture()] = None,
    seed: Seed = 0,
    effect_file: EffectFiles = None,
) -> None:
    """Find speed, pressure and hazard zones along the paths, by return period.

    \b
    Examples:
      avahazard zones first
      avahazard zones first --volumes volumes.csv
      avahazard zones first --limits french --path P01 --plot zones.png
    """
    from avahazard.workflow.zones import zones as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            return_periods=return_period or (),
            limits=limits,
            density=density,
            density_sd=density_sd,
            paths=path or (),
            source=volume_source(frequency, threshold, volumes, snowfall, density_ratio),
            seed=seed,
            plot=plot,
            effect_files=effect_file or (),
            report=report,
        )
    emit(context, found.rows, lambda console: show_zones(console, found.rows))
    warn(*found.notes)
