"""Speed of the block along its path."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.batch import Batch, march, new_batch, release
from avahazard.physics.cell_motion import end_accelerations, hermite
from avahazard.physics.cell_step import BATCH_SIZE
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import cubic_between


def speeds_along(cells: Cells, start: int, mu: Floats, x: Floats) -> Floats:
    """Speed (m/s) at the places x `[n_x]` for each friction `[n_friction]`.

    Zero before the release at node `start` and past the stop. Returns `[n_friction, n_x]`.
    """
    # In one piece: a slice such as MU[::4] would have the kernel compiled again.
    mu, x = np.ascontiguousarray(mu, np.float64), np.ascontiguousarray(x, np.float64)
    return np.asarray(_speeds(cells, start, mu, x))


@kernel
def _speeds(cells, start, mu, x):  # type: ignore[no-untyped-def]
    n_cells = len(cells.length)
    speeds = np.zeros((len(mu), len(x)))
    batch = new_batch(n_cells + 1, -1)
    for first in range(0, len(mu), BATCH_SIZE):
        n_moving = release(cells, start, mu, first, batch)
        march(cells, start, batch, n_moving)
        for k in range(len(x)):
            if cells.x[start] <= x[k] <= cells.x[n_cells]:
                i = min(np.searchsorted(cells.x, x[k], side="right") - 1, n_cells - 1)
                t = (x[k] - cells.x[i]) / (cells.x[i + 1] - cells.x[i])
                for j in range(min(BATCH_SIZE, len(mu) - first)):
                    if not np.isnan(batch.w[start, j]):
                        speeds[first + j, k] = speed_in_cell(cells, i, t, batch, j)
    return speeds


@kernel
def filled_speeds(speeds, stride):  # type: ignore[no-untyped-def]
    """Speeds `[n_friction, n_x]` from those at every `stride`-th friction.

    u² is a cubic between these, and goes straight to nought where the block stops.
    """
    n, n_x = speeds.shape
    square, fine = speeds.T.copy() ** 2, np.empty((stride * (n - 1) + 1, n_x))
    for k in range(n_x):
        for c in range(n - 1):
            moving = square[k, max(c - 1, 0) : c + 3] > 0.0
            smooth = 0 < c < n - 2 and np.all(moving)
            for j in range(stride):
                fine[stride * c + j, k] = cubic_between(square[k], c, j / stride, smooth)
        fine[stride * (n - 1), k] = square[k, n - 1]
    return np.sqrt(fine)


@kernel(inner=True)
def speed_in_cell(cells: Cells, i: int, t: float, batch: Batch, j: int) -> float:
    """Speed of block j at fraction t of cell i, of a block that was released above."""
    w0, w1 = batch.w[i, j], batch.w[i + 1, j]
    if batch.stop_cell[j] >= 0:
        if i > batch.stop_cell[j] or (i == batch.stop_cell[j] and t > batch.stop_t[j]):
            return 0.0
        if i == batch.stop_cell[j]:
            w1 = batch.stop_w1[j]
    h = cells.x[i + 1] - cells.x[i]
    a0, a1 = end_accelerations(cells, i, batch.friction[j], w0, w1)
    return np.sqrt(max(hermite(t, w0, h * a0, w1, h * a1), 0.0))
