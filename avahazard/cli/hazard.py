"""Commands on what is to be expected: volumes, hazard, zones, simulate, map."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import timedelta
from itertools import islice
from pathlib import Path
from typing import Annotated, Any

from avahazard.cli.options import CalibratedModel, answers, argument, flag, output_file
from avahazard.cli.output import SafeConsole, Shown, ask, emit, settings, show_next, table, warn
from avahazard.notes import Note, counted, grouped
from avahazard.report import tables
from avahazard.results.hazard import HazardRow, Zones
from avahazard.results.terrain import ChanceMap, SimulationPlan, Simulations
from avahazard.workflow import requests


def volumes(
    paths: Annotated[list[str] | None, argument("Paths; all without one.", "[PATH]…")] = None,
    *,
    request: requests.VolumesRequest,
) -> None:
    """Fit how often which volumes come down the paths: return levels and their error.

    \b
    Examples:
      avahazard volumes
      avahazard volumes P01 -T 30 -T 100 --plot levels.png
      avahazard volumes --frequency gpd --threshold 20000
    """
    found = ask("hazard.volumes", request=replace(request, paths=paths or ()))
    emit(found, lambda found: [tables.volumes_table(found.rows)])


MOST_ROWS = 500
"""Rows that people are shown; a program has them all."""


def hazard(
    names: Annotated[list[str], argument("A calibrated model; several are averaged.", "NAME…")],
    *,
    request: requests.HazardRequest,
) -> None:
    """Give the design runout of return periods, and the runout of volumes, path by path.

    The design runout is exceeded once in the period, by avalanches of all volumes at the rate of
    the path. Below it stands where avalanches of the volume of that period stop.

    Several models are averaged: each weighs as their mixture predicts left-out records best.

    Paths are stored as they are done: the same command goes on where it was interrupted. A path
    that fails is left out with its reason.

    \b
    Examples:
      avahazard hazard first
      avahazard hazard first -T 30 -T 300 --path P01
      avahazard hazard first -T 100 --frequency gpd
      avahazard hazard first -T 100 --volumes volumes.csv
      avahazard hazard first with-drag
      avahazard hazard first --engine processes --workers 8
      avahazard --json hazard first -V 20000 > bounds.json
    """
    found = ask("hazard.run_hazard", names=names, request=request)
    emit(
        found,
        lambda found: show_bounds(list(islice(found.rows(), MOST_ROWS)), found.failed),
        document=lambda found: found.documents(),
        notes=_beside_windows,
    )
    if found.n_rows > MOST_ROWS:
        warn(f"the first {MOST_ROWS} of {found.n_rows} rows are shown: --json, or export.")
    if not settings().as_json:
        step = ask("next_step.next_step", name=names[0])
        show_next(SafeConsole(), step, settings().database)


WINDOW = "data_window"
"""The note that is the first line of the answer, or what its key begins with."""


def _beside_windows(found: Any) -> list[Note]:
    return grouped(note for note in found.notes if not note.key.startswith(WINDOW))


def show_windows(notes: Iterable[Note]) -> Iterator[Shown]:
    """Show of which paths the rate rests on the years in which any path has records."""
    for note in grouped(note for note in notes if note.key.startswith(WINDOW)):
        yield f"{note[:1].upper()}{note[1:]}"


def show_bounds(
    rows: Sequence[HazardRow], failed: Mapping[str, str] | None = None
) -> Iterator[Shown]:
    """Show the rows of `hazard`: design runouts, else runouts of volumes; all, if asked for.

    First, where rates rest on the years of the data set; last, why paths `failed`.
    """
    verbose = settings().verbose
    yield from show_windows(note.about(row.path_id) for row in rows for note in row.notes)
    periods = [row for row in rows if row.return_period_years is not None]
    given = [row for row in rows if row.return_period_years is None]
    if periods:
        yield tables.design_table(periods)
    if rows and rows[0].by_model:
        yield tables.models_table(rows)
    if verbose or given:
        yield tables.volume_runout_table(rows if verbose else given)
    if verbose:
        yield from (
            tables.apart_table(rows),
            tables.period_volumes_table(rows),
            tables.points_table(rows),
        )
    elif periods:
        yield "Volumes, their runouts and places on the map: the same with avahazard --verbose."
    if failed:
        yield table("Left out", ("path", "why"), list(failed.items()))


FEW_PATHS = 8
"""Paths whose design runouts and speeds stand beside their zones without being asked for."""


def show_zones(found: Zones) -> Iterator[Shown]:
    """Show zones; of few paths, or if all is asked for, design runouts and speeds too."""
    entries = found.rows
    yield from show_windows(note for entry in entries for note in entry.notes)
    whole = settings().verbose or len(entries) <= FEW_PATHS
    if whole:
        yield tables.design_table(entries)
    yield tables.zones_table(entries)
    if whole:
        yield tables.speeds_table(entries)
    else:
        yield "Design runouts, speeds and pressures: the same with avahazard --verbose."


@answers("hazard.zones", notes=_beside_windows)
def zones(
    found: Zones, name: CalibratedModel, *, request: requests.ZonesRequest
) -> Iterator[Shown]:
    """Find speed, pressure and hazard zones along the paths, by return period.

    A model needs drag (calibrate it with turbulent-drag, or import measured speeds): without,
    nothing but friction limits its speeds, and --no-drag has to accept that.

    \b
    Examples:
      avahazard zones first --no-drag
      avahazard zones with-drag
      avahazard zones with-drag --volumes volumes.csv
      avahazard zones with-drag --limits french --path P01 --plot zones.png
    """
    return show_zones(found)


def simulate(
    paths: Annotated[
        list[str] | None, argument("Paths; all with terrain without one.", "[PATH]…")
    ] = None,
    *,
    request: requests.SimulateRequest,
    dry_run: Annotated[bool, flag("--dry-run", "Estimate time and disk, and run nothing.")] = False,
) -> None:
    """Run AvaFrame's com1DFA on the terrain of paths, over friction and volume.

    Each run is stored when it ends: the same command goes on where it was interrupted. AvaFrame
    has an environment of its own, made by `make avaframe` or named by AVAHAZARD_AVAFRAME.

    \b
    Examples:
      avahazard simulate --dry-run
      avahazard simulate P01
      avahazard simulate P01 -V 5000 -V 50000 --drag 0.002
      avahazard simulate --engine processes --workers 8
    """
    asked = replace(request, paths=tuple(paths or ()))
    if dry_run:
        emit(ask("flow.plan_simulations", request=asked), _plan)
    else:
        emit(ask("flow.simulate_paths", request=asked), show_simulations)


def _plan(plan: SimulationPlan) -> Iterator[Shown]:
    done = f", {plan.n_done} of them stored already" if plan.n_done else ""
    yield f"{counted(plan.n_runs, 'run')}{done}."
    by = "the mean of stored runs" if plan.measured else "a guess from the number of cells"
    yield (
        f"Time: about {timedelta(seconds=round(plan.seconds))} (h:min:s) with {plan.workers} "
        f"workers, {plan.seconds_per_run:.0f} s a run ({by}). Refinement can take three times as "
        f"long.\nDatabase: about {plan.stored_bytes / 1e6:.2g} MB."
    )


def show_simulations(found: Simulations) -> Iterator[Shown]:
    """Show how many runs each path has, and how far they came."""
    rows = [
        (
            row.path_id,
            row.n_runs,
            row.n_new,
            f"{row.friction_min:g} to {row.friction_max:g}",
            f"{row.volume_min_m3:g} to {row.volume_max_m3:g}",
            "none"
            if row.stop_min_x_m is None
            else f"{row.stop_min_x_m:.0f} to {row.stop_max_x_m:.0f}",
            row.left,
        )
        for row in found.rows
    ]
    heads = ("path", ">runs", ">new", "friction", "volume m³", "stop x m", ">left")
    yield table("Runs of com1DFA", heads, rows)


@answers("flow.draw_map")
def map(
    found: ChanceMap,
    name: CalibratedModel,
    file: Annotated[Path, output_file("Ends in .tif (chances) or .gpkg (areas and zones).")],
    *,
    request: requests.MapRequest,
) -> Iterator[Shown]:
    """Draw the annual chance of an avalanche, and of pressures, in the cells of the terrain.

    Where paths have runs of `simulate`; on others along the line, as wide as the flow. The bands
    of a .tif: the chance that an avalanche comes, its 5 and 95 %, the chances that peak pressure
    exceeds 3, 10 and 30 kPa, and the engine (1 the block, 2 com1DFA).

    \b
    Examples:
      avahazard map flow -o chances.tif
      avahazard map flow -o zones.gpkg --limits french
    """
    rows = [(row.path_id, row.engine, row.n_runs, f"{row.chance_max:.3f}") for row in found.paths]
    title = f"{found.file}: {found.crs}, cells of {found.cell_m:g} m"
    yield table(title, ("path", "engine", ">runs", ">largest chance a year"), rows)
    yield f"It holds: {', '.join(found.bands)}."
