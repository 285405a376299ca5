"""Commands on flow models in two dimensions: simulate, map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.hazard import duration
from avahazard.cli.options import CalibratedModel, output_file
from avahazard.cli.output import ask, emit, table
from avahazard.notes import counted
from avahazard.results.terrain import ChanceMap, SimulationPlan, Simulations
from avahazard.workflow.requests import MapRequest, SimulateRequest


def simulate(
    paths: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PATH]…", help="Paths; all with terrain without one.", show_default=False
        ),
    ] = None,
    *,
    request: SimulateRequest,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what it will take at least, and run nothing.")
    ] = False,
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
        emit(ask("simulate.plan_simulations", request=asked), show_simulation_plan)
    else:
        emit(ask("simulate.simulate_paths", request=asked), show_simulations)


def show_simulations(console: Console, found: Simulations) -> None:
    """Print how many runs each path has, and how far they came."""
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
    console.print(table("Runs of com1DFA", heads, rows))


def show_simulation_plan(console: Console, plan: SimulationPlan) -> None:
    """Print what `simulate` will take."""
    done = f", {plan.n_done} of them done already" if plan.n_done else ""
    console.print(f"{counted(plan.n_paths, 'path')}, {counted(plan.n_runs, 'run')} at first{done}.")
    by = "as stored runs took" if plan.measured else "guessed by the number of cells"
    console.print(
        f"About {duration(plan.seconds)} with {plan.workers} workers "
        f"({plan.seconds_per_run:.0f} s a run, {by}); refining can take three times as long."
    )
    console.print(f"Database: about {plan.stored_bytes / 1e6:.2g} MB.")


def map(
    name: CalibratedModel,
    file: Annotated[Path, output_file("Ends in .tif (chances) or .gpkg (areas and zones).")],
    *,
    request: MapRequest,
) -> None:
    """Draw the annual chance of an avalanche, and of pressures, in the cells of the terrain.

    Where paths have runs of `simulate`; on others along the line, as wide as the flow. The bands
    of a .tif: the chance that an avalanche comes, its 5 and 95 %, the chances that peak pressure
    exceeds 3, 10 and 30 kPa, and the engine (1 the block, 2 com1DFA).

    \b
    Examples:
      avahazard map flow -o chances.tif
      avahazard map flow -o zones.gpkg --limits french
    """
    emit(ask("map.draw_map", name=name, file=file, request=request), show_map)


def show_map(console: Console, found: ChanceMap) -> None:
    """Print what a map holds."""
    rows = [(row.path_id, row.engine, row.n_runs, f"{row.chance_max:.3f}") for row in found.paths]
    title = f"{found.file}: {found.crs}, cells of {found.cell_m:g} m"
    console.print(table(title, ("path", "engine", ">runs", ">largest chance a year"), rows))
    console.print(f"It holds: {', '.join(found.bands)}.")
