"""`avahazard hazard`."""

from __future__ import annotations

from itertools import islice
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
    all_over,
    return_periods,
    volume_source,
)
from avahazard.cli.output import emit, emit_rows, warn
from avahazard.cli.plan_table import show_plan
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings

MOST_ROWS, MOST_NOTES = 500, 100
"""Rows and notes that people are shown; a program has them all."""


def hazard(
    context: typer.Context,
    name: CalibratedModel,
    return_period: Annotated[
        list[float] | None,
        return_periods("May be given again. [default: 100, where no volume is given]"),
    ] = None,
    volume: Annotated[
        list[float] | None,
        typer.Option(
            "-V", "--volume", metavar="M3", help="May be given again.", callback=all_over(0.0)
        ),
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
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what it will take, and compute nothing.")
    ] = False,
) -> None:
    """Give the design runout of return periods, and the runout of volumes, path by path.

    The design runout is exceeded once in the period, by avalanches of all volumes at the rate of
    the path. Below it stands where avalanches of the volume of that period stop.

    Paths are stored as they are done: the same command goes on where it was interrupted. A path
    that fails is left out with its reason.

    \b
    Examples:
      avahazard hazard first
      avahazard hazard first -T 30 -T 300 --path P01
      avahazard hazard first -T 100 --frequency gpd
      avahazard hazard first -T 100 --volumes volumes.csv
      avahazard hazard first --dry-run
      avahazard hazard first --engine processes --workers 8
      avahazard --json hazard first -V 20000 > bounds.json
    """
    from avahazard.workflow.hazard import HazardQuestion, run_hazard  # noqa: PLC0415
    from avahazard.workflow.hazard_plan import plan_hazard  # noqa: PLC0415

    database = settings(context).database
    question = HazardQuestion(
        return_periods=return_period or (),
        volumes=volume or (),
        paths=path or (),
        source=volume_source(frequency, threshold, volumes, snowfall, density_ratio),
        n_draws=draws,
        seed=seed,
        effect_files=effect_file or (),
    )
    if dry_run:
        plan = plan_hazard(database, name, question)
        emit(context, plan, lambda console: show_plan(console, plan))
        return
    with show_progress() as report:
        found = run_hazard(database, name, question, report)
    emit_rows(
        context,
        found.documents(),
        lambda console: show_bounds(console, list(islice(found.rows(), MOST_ROWS)), found.failed),
    )
    if found.n_rows > MOST_ROWS:
        warn(f"the first {MOST_ROWS} of {found.n_rows} rows are shown: --json, or export.")
    warn(*found.notes[:MOST_NOTES])
    if len(found.notes) > MOST_NOTES:
        warn(f"and {len(found.notes) - MOST_NOTES} more notes, which are with the rows of --json.")
