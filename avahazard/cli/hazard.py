"""Commands on what is to be expected: volumes, hazard, zones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.hazard_tables import show_bounds, show_plan, show_zones
from avahazard.cli.options import CalibratedModel
from avahazard.cli.output import emit, emit_rows, settings, table, warn
from avahazard.cli.progress import show_progress
from avahazard.notes import grouped
from avahazard.results.hazard import PathVolumes
from avahazard.workflow.requests import HazardRequest, VolumesRequest, ZonesRequest


def volumes(
    context: typer.Context,
    path: Annotated[
        list[str] | None,
        typer.Argument(metavar="[PATH]…", help="Paths; all without one.", show_default=False),
    ] = None,
    *,
    request: VolumesRequest,
) -> None:
    """Fit how often which volumes come down the paths: return levels and their error.

    \b
    Examples:
      avahazard volumes
      avahazard volumes P01 -T 30 -T 100 --plot levels.png
      avahazard volumes --frequency gpd --threshold 20000
    """
    from avahazard.workflow.volumes import volumes as run  # noqa: PLC0415

    found = run(settings(context).database, replace(request, paths=path or ()))
    emit(context, found.rows, lambda console: _show_volumes(console, found.rows))
    warn(*found.notes)


def _show_volumes(console: Console, entries: Sequence[PathVolumes]) -> None:
    rows = []
    for entry in entries:
        name = entry.path_id
        for level in entry.levels:
            far = "*" if level.extrapolated else ""
            period = f"{level.return_period_years:g}{far}"
            interval = f"{_volume_text(level.q05_m3)}–{_volume_text(level.q95_m3)}"
            rows.append((name, period, _volume_text(level.volume_m3), interval))
            name = ""
    columns = ("path", ">T yr", ">V m3", ">5–95 % m3")
    console.print(table("Volumes of return periods, with 90 % of their posterior", columns, rows))
    for entry in entries:
        console.print(f"{entry.path_id}: {entry.method}.")
    if any(level.extrapolated for entry in entries for level in entry.levels):
        console.print("*: an extrapolation, past twice the record or past the table.")


def _volume_text(value: float) -> str:
    """A volume to three digits."""
    return f"{float(f'{value:.3g}'):.0f}" if value < 1e6 else f"{value:.3g}"


MOST_ROWS, MOST_NOTES = 500, 100
"""Rows and notes that people are shown; a program has them all."""


def hazard(
    context: typer.Context,
    name: CalibratedModel,
    *,
    request: HazardRequest,
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
    from avahazard.workflow.hazard import plan_hazard, run_hazard  # noqa: PLC0415

    database = settings(context).database
    if dry_run:
        plan = plan_hazard(database, name, request)
        emit(context, plan, lambda console: show_plan(console, plan))
        return
    with show_progress() as report:
        found = run_hazard(database, name, request, report)
    emit_rows(
        context,
        found.documents(),
        lambda console: show_bounds(console, list(islice(found.rows(), MOST_ROWS)), found.failed),
    )
    if found.n_rows > MOST_ROWS:
        warn(f"the first {MOST_ROWS} of {found.n_rows} rows are shown: --json, or export.")
    notes = grouped(found.notes)
    warn(*notes[:MOST_NOTES])
    if len(notes) > MOST_NOTES:
        warn(f"and {len(notes) - MOST_NOTES} more notes, which are with the rows of --json.")


def zones(
    context: typer.Context,
    name: CalibratedModel,
    *,
    request: ZonesRequest,
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
        found = run(settings(context).database, name, request, report)
    emit(context, found.rows, lambda console: show_zones(console, found.rows))
    warn(*found.notes)
