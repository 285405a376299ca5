"""1000 frictions with drag and forest down the longest Tyrol profile, against solve_ivp."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects.site import SPEED_CELL_M
from avahazard.physics.block import STOPPED, run
from avahazard.physics.cells import SPEEDS, build_cells, no_resistance
from avahazard.physics.terrain import MAX_CELL_M, build_terrain
from benchmarks.cases.solver import pieces, solve
from benchmarks.cases.solver_effects import motion
from benchmarks.cases.tyrol import MU, longest
from benchmarks.measuring import Result, alternate, seconds

SAMPLE = MU[12::40]
"""The solver is timed on every 40th friction and scaled."""
DRAG, FOREST_DRAG = 0.001, 0.01
FOREST = (0.35, 0.55)
"""Shares of the path between which it stands in forest."""
RATIO, HALF_SPEED = 0.6, 10.0


def measure() -> Result:
    """With drag and forest, friction by itself."""
    return against_solver(1.0, 400_000.0, 10.0)


def against_solver(ratio: float, target: float, allowed_m: float) -> Result:
    """Times per 1000 runs where friction falls to `ratio` with speed; fails if a stop is off."""
    profile = longest("auto")
    weak = ratio < 1.0
    length = profile.x_max - profile.x_min
    forest = np.array([*(profile.x_min + length * np.array(FOREST)), FOREST_DRAG])
    terrain = build_terrain(profile, forest[:2], SPEED_CELL_M if weak else MAX_CELL_M)
    inside = (terrain.middle_x >= forest[0]) & (terrain.middle_x < forest[1])
    bare = no_resistance(terrain)
    resistance = replace(bare, drag=bare.drag + DRAG + FOREST_DRAG * inside)
    if weak:
        share = ratio + (1.0 - ratio) / (1.0 + SPEEDS / HALF_SPEED)
        resistance = replace(resistance, speed_factor=share)
    cells, start, path = build_cells(terrain, resistance), np.array([0]), pieces(profile)

    def stop(mu: float, rtol: float) -> float:
        resisting = mu, DRAG, forest, ratio, HALF_SPEED
        return float(solve(path, terrain.x[0], rtol, *resisting, motion=motion))

    errors = []
    for mu in SAMPLE:
        stops = run(cells, start, mu + np.array([-1e-6, 0.0, 1e-6]))
        if np.all(stops.status == STOPPED) and stops.x[0, 0] - stops.x[0, 2] < 0.1:
            errors.append(abs(stops.x[0, 1] - stop(mu, 1e-10)))
    if not max(errors) <= allowed_m:
        raise SystemExit(f"A stop is off by {max(errors):.3f} m.")

    def theirs() -> float:
        return seconds(lambda: [stop(mu, 1e-8) for mu in SAMPLE]) * len(MU) / len(SAMPLE)

    ours, rival, times = alternate(lambda: seconds(lambda: run(cells, start, MU), 10), theirs, 5)
    return Result(
        times,
        1e3 * ours,
        1e3 * rival,
        "ms per 1000 runs",
        target,
        False,
        "time of `solve_ivp` (DOP853, event, rtol 1e-8) over ours",
        f"{len(cells.length)} cells, drag {DRAG:g} 1/m and {FOREST_DRAG:g} in forest"
        + (f", friction falling to {ratio:g} of it with speed" if weak else "")
        + f"; stops are off by {np.median(errors):.3f} m at the median, {max(errors):.2f} m at "
        f"most ({len(errors)} stops against rtol 1e-10). The solver as for `run`.",
    )
