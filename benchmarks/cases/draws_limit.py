"""1e7 runouts from P[μ|V] against numpy's normal draws and numpy.interp."""

from __future__ import annotations

from functools import partial

import numpy as np

from avahazard.hazard.rows import draw_stops
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import MU, friction_grid, pieces, tabulate
from avahazard.physics.terrain import build_terrain
from benchmarks.cases.tyrol import longest
from benchmarks.measuring import Result, alternate, seconds

N = 10_000_000
N_POSTERIOR = 4000
MEAN, SD = 0.5, 0.08


def measure() -> Result:
    """Times per 1e7 draws."""
    terrain = build_terrain(longest("legendre"))
    curve = tabulate(build_cells(terrain, no_resistance(terrain)), np.array([0]))[0]
    friction, scatter = np.full(N_POSTERIOR, MEAN), np.full(N_POSTERIOR, SD)
    curves, of = (*pieces(curve[None]), friction_grid(curve.mu)), np.zeros(N_POSTERIOR, np.int64)
    log_scatter = np.full(N_POSTERIOR, SD / MEAN)
    filled = np.where(curve.left, terrain.x[-1], curve.x)
    rng = np.random.default_rng(1)

    def rounds(distribution, spread, transform):  # type: ignore[no-untyped-def]
        def ours() -> float:
            in_log = distribution == "lognormal"
            location = np.log(friction) if in_log else friction
            drawn = partial(draw_stops, curves, of, location, spread, N, rng, in_log=in_log)
            return seconds(drawn)

        def theirs() -> float:
            return seconds(lambda: np.interp(transform(rng.standard_normal(N)), MU, filled))

        return alternate(ours, theirs, 5)

    normal = rounds("normal", scatter, lambda z: MEAN + SD * z)
    lognormal = rounds("lognormal", log_scatter, lambda z: MEAN * np.exp(SD / MEAN * z))
    return Result(
        normal[2],
        normal[0],
        normal[1],
        "s per 1e7 draws",
        2.5,
        False,
        "time of `standard_normal` and `numpy.interp` over ours",
        "normal friction. Ours gives x and elevation of every stop, counts statuses, never "
        "interpolates across a jump of F, and draws over 4000 posterior draws; theirs gives x "
        f"alone. With lognormal friction on both sides the ratio is {lognormal[2]:.2f}.",
    )
