"""Speed of the block along its path."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.physics.block import LANES, _releases, cell_step, finish_cell
from avahazard.physics.cell_motion import end_accelerations, hermite
from avahazard.physics.cells import Cells
from avahazard.physics.constants import KEEPS_NAN

Floats = NDArray[np.float64]


def speeds_along(cells: Cells, start: int, mu: Floats, x: Floats) -> Floats:
    """Speed (m/s) at the places x `[n_x]` for each friction `[n_friction]`.

    Zero before the release at node `start` and past the stop. Returns `[n_friction, n_x]`.
    """
    return np.asarray(
        _speeds(cells, start, np.asarray(mu, dtype=np.float64), np.asarray(x, dtype=np.float64))
    )


@njit(cache=True, fastmath=KEEPS_NAN)
def _speeds(cells, start, mu, x):  # type: ignore[no-untyped-def]
    n_cells = len(cells.length)
    order = np.argsort(x)
    speeds = np.zeros((len(mu), len(x)))
    friction = np.empty(LANES)
    w = np.empty(LANES)
    w_new = np.empty(LANES)
    moving = np.ones(LANES, dtype=np.int64)
    flag = np.zeros(LANES, dtype=np.int64)
    for k in range(len(mu)):
        if start >= n_cells or not _releases(cells, start, mu[k]):
            continue
        friction[:] = mu[k]
        w[:] = 0.0
        place = 0
        while place < len(x) and x[order[place]] < cells.x[start]:
            place += 1
        for i in range(start, n_cells):
            t_stop = -1.0
            if cell_step(cells, i, friction, moving, w, w_new, flag):
                w_end, t_stop, _ = finish_cell(cells, i, mu[k], w[0], w_new[0])
                w_new[:] = w_end
            h = cells.x[i + 1] - cells.x[i]
            end = 1.0 if t_stop < 0.0 else t_stop
            a0, a1 = end_accelerations(cells, i, mu[k], w[0], w_new[0])
            while place < len(x) and x[order[place]] <= cells.x[i] + end * h:
                t = (x[order[place]] - cells.x[i]) / h
                value = hermite(t, w[0], h * a0, w_new[0], h * a1)
                speeds[k, order[place]] = np.sqrt(max(value, 0.0))
                place += 1
            if t_stop >= 0.0 or place == len(x):
                break
            w[:] = w_new
    return speeds
