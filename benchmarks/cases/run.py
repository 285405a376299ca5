"""1000 frictions down the longest Tyrol profile against scipy's solve_ivp on equation 2.3."""

from __future__ import annotations

import numpy as np

from avahazard.physics.block import STOPPED, run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.terrain import build_terrain
from benchmarks.cases.solver import pieces, solve
from benchmarks.cases.tyrol import MU, longest
from benchmarks.measuring import Result, alternate, seconds

SAMPLE = MU[12::40]
"""The solver is timed on every 40th friction and scaled."""
ALLOWED_M = 0.1


def measure() -> Result:
    """Times per 1000 runs; fails if a stop is off by more than 0.1 m."""
    profile = longest("auto")
    terrain = build_terrain(profile)
    cells, start = build_cells(terrain, no_resistance(terrain)), np.array([0])
    path = pieces(profile)
    error, n = largest_error(cells, start, path)
    if not error <= ALLOWED_M:
        raise SystemExit(f"run: a stop is off by {error:.3f} m.")

    def theirs() -> float:
        once = seconds(lambda: [solve(path, terrain.x[0], 1e-8, mu) for mu in SAMPLE])
        return once * len(MU) / len(SAMPLE)

    ours, rival, ratio = alternate(lambda: seconds(lambda: run(cells, start, MU), 20), theirs, 5)
    return Result(
        ratio,
        1e3 * ours,
        1e3 * rival,
        "ms per 1000 runs",
        310_000.0,
        False,
        "time of `solve_ivp` (DOP853, event, rtol 1e-8) over ours",
        f"{len(cells.length)} cells, of which blocks leave and meet the ground in many; largest "
        f"error of a stop {1e3 * error:.1f} mm ({n} stops against rtol 1e-10). The solver has a "
        f"compiled right-hand side over the spline's own polynomials, and is timed on "
        f"{len(SAMPLE)} of the frictions, scaled.",
    )


def largest_error(cells, start, path):  # type: ignore[no-untyped-def]
    """Largest distance of our stops from the solver's at rtol 1e-10, where F does not jump."""
    errors = []
    for mu in SAMPLE:
        stops = run(cells, start, mu + np.array([-1e-6, 0.0, 1e-6]))
        x = stops.x[0]
        if np.all(stops.status == STOPPED) and x[0] - x[2] < ALLOWED_M:
            errors.append(abs(x[1] - solve(path, cells.x[0], 1e-10, mu)))
    return max(errors), len(errors)
