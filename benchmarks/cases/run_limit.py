"""The block against a bare loop of the multiply-adds of its exact form."""

from __future__ import annotations

import numpy as np
from numba import njit

from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.cell_step import BATCH_SIZE
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.terrain import build_terrain
from benchmarks.cases.tyrol import MU, longest
from benchmarks.measuring import Result, alternate, processor_seconds


@njit(fastmath={"contract"})
def bare(growth, drive, mu, n_cells, w_end):  # type: ignore[no-untyped-def]
    """w ← A(μ) w + B(μ), two polynomials of order 6, over the first cells; nothing else."""
    friction, w = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE)
    for b in range(len(n_cells)):
        for j in range(BATCH_SIZE):
            friction[j] = mu[min(b * BATCH_SIZE + j, len(mu) - 1)]
            w[j] = 0.0
        for i in range(n_cells[b]):
            g0, g1, g2, g3 = growth[i, 0], growth[i, 1], growth[i, 2], growth[i, 3]
            g4, g5, g6 = growth[i, 4], growth[i, 5], growth[i, 6]
            d0, d1, d2, d3 = drive[i, 0], drive[i, 1], drive[i, 2], drive[i, 3]
            d4, d5, d6 = drive[i, 4], drive[i, 5], drive[i, 6]
            for j in range(BATCH_SIZE):
                m = friction[j]
                a = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
                c = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
                w[j] = a * w[j] + c
        for j in range(min(BATCH_SIZE, len(mu) - b * BATCH_SIZE)):
            w_end[b * BATCH_SIZE + j] = w[j]


def sides(method: str):  # type: ignore[no-untyped-def]
    """Our run and the bare loop over the cells that our blocks pass, as functions."""
    terrain = build_terrain(longest(method))
    cells, start = build_cells(terrain, no_resistance(terrain)), np.array([0])
    stops = run(cells, start, MU)
    last = np.zeros(len(MU), dtype=np.int64)
    stopped, left = stops.status[0] == STOPPED, stops.status[0] == LEFT_PROFILE
    last[stopped] = np.searchsorted(cells.x, stops.x[0][stopped])
    last[left] = len(cells.length)
    n_cells = np.maximum.reduceat(last, np.arange(0, len(MU), BATCH_SIZE))
    w_end = np.empty(len(MU))
    return (
        lambda: processor_seconds(lambda: run(cells, start, MU), 50),
        lambda: processor_seconds(lambda: bare(cells.growth, cells.drive, MU, n_cells, w_end), 50),
    )


def measure() -> Result:
    """Times per 1000 runs on the polynomial, where blocks stay on the ground."""
    ours, theirs, ratio = alternate(*sides("legendre"), rounds=41)
    rough = alternate(*sides("spline"), rounds=11)
    return Result(
        ratio,
        1e3 * ours,
        1e3 * theirs,
        "CPU-ms per 1000 runs",
        0.5,
        False,
        "time of a bare compiled loop of the same multiply-adds over ours",
        "the bare loop steps the same cells in the same blocks of 32 frictions, as far as the last "
        "block of them goes, and looks for no stop. On the polynomial, where the exact form holds "
        "throughout; ours also finds stops, statuses and elevations. On the spline through the "
        f"same points, where blocks leave the ground and land again, the ratio is {rough[2]:.2f} "
        f"({1e3 * rough[0]:.2f} ms): there ours finds where contact changes as well.",
    )
