"""The runout of one release as a function of friction, in the form that fast draws need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.physics.block import LEFT_PROFILE, STOPPED

Floats = NDArray[np.float64]

JUMP_FACTOR = 5.0
"""A cell is a jump where the stop moves this many times as far as in the wider cell beside it."""


@dataclass(frozen=True, slots=True, eq=False)
class RunoutCurve:
    """Stops of one release over a uniform grid of friction, arrays `[n_friction]`.

    Friction of node j is `mu_min + j * mu_step`; `stop_x`, `stop_y` in m, nan where the block left
    the profile and the release where it was not released; `status` as in `physics.block`.
    """

    mu_min: float
    mu_step: float
    stop_x: Floats
    stop_y: Floats
    status: NDArray[np.int8]


def pieces(curve: RunoutCurve) -> tuple[Floats, NDArray[np.int8]]:
    """Straight pieces of half a cell each, and their status: `[2 n_friction, 4]`, `[2 n_friction]`.

    In units t = (μ - mu_min) / mu_step, piece k holds for k - 1 ≤ 2t < k; the first and the last
    hold for everything below and above the grid, at the value of the end node. A row is
    (x at t = 0, dx/dt, y at t = 0, dy/dt). A cell whose ends differ in status, or over which the
    stop jumps, has two flat halves: each draw takes the nearer node's stop, so nothing stops where
    no run of the block does. Left of profile is x = +inf, y = -inf.
    """
    n = len(curve.status)
    left = curve.status == LEFT_PROFILE
    x = np.where(left, np.inf, curve.stop_x)
    y = np.where(left, -np.inf, curve.stop_y)
    flat = broken_cells(x, curve.status)
    rows = np.zeros((2 * n, 4))
    node = np.repeat(np.arange(n), 2)  # each node owns the half cells on both its sides
    rows[:, 0], rows[:, 2] = x[node], y[node]
    cells = np.flatnonzero(~flat)
    for column, value in ((0, x), (2, y)):
        slope = value[cells + 1] - value[cells]
        for half in (2 * cells + 1, 2 * cells + 2):
            rows[half, column] = value[cells] - slope * cells
            rows[half, column + 1] = slope
    return rows, curve.status[node]


def broken_cells(x: Floats, status: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Cells `[n_friction - 1]` that must not be interpolated."""
    same = status[1:] == status[:-1]
    moving = same & (status[1:] == STOPPED)
    gap = np.zeros(len(x) - 1)
    gap[moving] = np.abs(np.diff(np.where(np.isfinite(x), x, 0.0)))[moving]
    padded = np.r_[0.0, gap, 0.0]
    beside = np.maximum(padded[:-2], padded[2:])
    jump = moving & (beside > 0) & (gap > JUMP_FACTOR * beside)
    broken: NDArray[np.bool_] = ~moving | jump
    return broken
