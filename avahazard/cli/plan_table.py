"""What a run of `hazard` will take, for people."""

from __future__ import annotations

from rich.console import Console

from avahazard.message import counted
from avahazard.results.hazard import HazardPlan


def show_plan(console: Console, plan: HazardPlan) -> None:
    """Print what a run of `hazard` will take."""
    done = f", {plan.n_done} of them done already" if plan.n_done else ""
    size = f"{counted(plan.n_paths, 'path')}{done}, {counted(plan.n_rows, 'row')}"
    console.print(f"{size}, {plan.n_runs:.3g} runs.")
    console.print(
        f"About {_duration(plan.seconds)} by {plan.engine} with {plan.workers} workers "
        f"({plan.seconds_per_path:.2g} s a path, measured on {plan.measured_paths})."
    )
    for what, need, free in (
        ("Memory", plan.memory_bytes, plan.memory_free_bytes),
        ("Database", plan.stored_bytes, plan.disk_free_bytes),
    ):
        there = "" if free is None else f" of {free / 1e9:.2g} GB free"
        console.print(f"{what}: about {need / 1e9:.2g} GB{there}.")


def _duration(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
