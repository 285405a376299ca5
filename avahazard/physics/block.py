"""Runs of the block down a path: the batch kernel over friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.batch import march, new_batch, release
from avahazard.physics.cell_motion import elevation_in_cell
from avahazard.physics.cell_step import BATCH_SIZE
from avahazard.physics.cells import Cells

STOPPED, LEFT_PROFILE, NOT_RELEASED = 0, 1, 2
STATUS_NAMES = ("stopped", "left_profile", "not_released")


class Stops(NamedTuple):
    """Ends of runs, each array `[n_starts, n_friction]`.

    `x`, `y` (m) are nan where the block left the profile and the release where it was not
    released; `status` is one of STOPPED, LEFT_PROFILE, NOT_RELEASED; `lift_off_x` is where the
    block first lost contact with its bed, nan where it never did.
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]
    lift_off_x: Floats


def run(cells: Cells, starts: NDArray[np.int64], mu: Floats) -> Stops:
    """Run the block from each start node with each friction.

    `starts` `[n_starts]` are node indices, `mu` `[n_friction]` Coulomb frictions (any order;
    neighbours that are close run fastest).
    """
    # In one piece: a slice such as MU[::4] would have the kernel compiled again.
    mu = np.ascontiguousarray(mu, dtype=np.float64)
    return Stops(*_run(cells, np.asarray(starts, dtype=np.int64), mu))


@kernel
def _run(cells, starts, mu):  # type: ignore[no-untyped-def]
    n_starts, n_mu = len(starts), len(mu)
    stop_x = np.full((n_starts, n_mu), np.nan)
    stop_y = np.full((n_starts, n_mu), np.nan)
    lift_off_x = np.full((n_starts, n_mu), np.nan)
    status = np.full((n_starts, n_mu), LEFT_PROFILE, dtype=np.int8)
    batch = new_batch(2, 1)
    for s in range(n_starts):
        start = starts[s]
        for first in range(0, n_mu, BATCH_SIZE):
            n_moving = release(cells, start, mu, first, batch)
            for j in range(min(BATCH_SIZE, n_mu - first)):
                if np.isnan(batch.w[start & 1, j]):
                    status[s, first + j] = NOT_RELEASED
                    stop_x[s, first + j] = cells.x[start]
                    stop_y[s, first + j] = cells.y[start]
            march(cells, start, batch, n_moving)
            for j in range(min(BATCH_SIZE, n_mu - first)):
                lift_off_x[s, first + j] = batch.lost_x[j]
                i = batch.stop_cell[j]
                if i >= 0:
                    t = batch.stop_t[j]
                    status[s, first + j] = STOPPED
                    stop_x[s, first + j] = cells.x[i] + t * (cells.x[i + 1] - cells.x[i])
                    stop_y[s, first + j] = elevation_in_cell(cells, i, t)
    return stop_x, stop_y, status, lift_off_x
