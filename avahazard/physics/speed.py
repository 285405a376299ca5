"""Speed of the block along its path, and of what no one friction brings to rest at its place.

Where F jumps no block with one friction stops, and yet avalanches do: their friction goes up and
down. With its mean the block of `block.run` would stop before it is there; in `squares_to_rest` it
is carried on (u² below zero, and then no force but gravity and friction), so that work along the
whole way is that of the mean friction.
"""

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.block import BATCH_SIZE, Batch, march, new_batch, release
from avahazard.physics.cell_motion import at_speed, end_accelerations, hermite
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import refined


def speeds_along(cells: Cells, start: int, mu: Floats, x: Floats) -> Floats:
    """Speed (m/s) at the places x `[n_x]` for each friction `[n_friction]`.

    Zero before the release at node `start` and past the stop. Returns `[n_friction, n_x]`.
    """
    # In one piece: a slice such as MU[::4] would have the kernel compiled again.
    mu, x = np.ascontiguousarray(mu, np.float64), np.ascontiguousarray(x, np.float64)
    return np.asarray(_speeds(cells, start, mu, x, np.searchsorted(cells.x, x, side="right") - 1))


@kernel
def _speeds(cells, start, mu, x, cell):  # type: ignore[no-untyped-def]
    n_cells = len(cells.length)
    speeds = np.zeros((len(mu), len(x)))
    batch = new_batch(n_cells + 1, -1)
    for first in range(0, len(mu), BATCH_SIZE):
        n_moving = release(cells, start, mu[first:], batch)
        march(cells, start, batch, n_moving)
        for k in range(len(x)):
            if cells.x[start] <= x[k] <= cells.x[n_cells]:
                i = min(cell[k], n_cells - 1)
                t = (x[k] - cells.x[i]) / (cells.x[i + 1] - cells.x[i])
                for j in range(min(BATCH_SIZE, len(mu) - first)):
                    if not np.isnan(batch.w[start, j]):
                        speeds[first + j, k] = speed_in_cell(cells, i, t, batch, j)
    return speeds


def filled_speeds(speeds: Floats) -> Floats:
    """Speeds `[n_friction, n_x]` from those at every `COARSE`-th friction (`refined`).

    u² is a cubic between these, and goes straight to zero where the block stops.
    """
    square = speeds.T**2
    moving = square > 0.0
    smooth = np.zeros(moving[:, 1:].shape, np.bool_)
    smooth[:, 1:-1] = moving[:, :-3] & moving[:, 1:-2] & moving[:, 2:-1] & moving[:, 3:]
    fine = refined(square, smooth).reshape(len(square), -1)
    return np.ascontiguousarray(np.sqrt(np.column_stack([fine, square[:, -1]])).T)


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


TRIED = np.linspace(0.0, 2.0, 81)
"""Frictions between which the mean is sought; between two of them u² goes nearly straight."""


def squares_to_rest(cells: Cells, start: int, stop_x: float, x: Floats) -> Floats:
    """u² (m²/s²) at the places x `[n_x]` of what starts at node `start` and rests at `stop_x`."""
    node_x = cells.x[start:]
    square = carried(cells, start, TRIED)
    at_stop = _at(square, node_x, np.array([stop_x]))[0]
    # More friction, less speed.
    k = int(np.clip(np.searchsorted(-at_stop, 0.0), 1, len(TRIED) - 1))
    places = np.where((x < node_x[0])[:, None], 0.0, _at(square[:, k - 1 : k + 1], node_x, x))
    share = np.clip(at_stop[k - 1] / max(at_stop[k - 1] - at_stop[k], 1e-12), 0.0, 1.0)
    return np.asarray((1.0 - share) * places[:, 0] + share * places[:, 1])


def _at(square: Floats, node_x: Floats, x: Floats) -> Floats:
    """u² of the nodes `[n_nodes, n_friction]` at places x between them, `[n_x, n_friction]`."""
    right = np.clip(np.searchsorted(node_x, x), 1, len(node_x) - 1)
    share = np.clip((x - node_x[right - 1]) / (node_x[right] - node_x[right - 1]), 0.0, 1.0)
    return np.asarray((1.0 - share[:, None]) * square[right - 1] + share[:, None] * square[right])


@kernel
def carried(cells, start, mu):  # type: ignore[no-untyped-def]
    """u² at the nodes from `start` on, carried on below zero, `[n_nodes, n_friction]`."""
    n_cells, n, n_powers = len(cells.length), len(mu), cells.growth.shape[1]
    square = np.zeros((n_cells + 1 - start, n))
    for i in range(start, n_cells):
        k = i - start
        for j in range(n):
            moving = max(square[k, j], 0.0)
            friction, push = mu[j] * cells.factor[i], 0.0
            if cells.speed_dependent:
                friction *= at_speed(cells.speed_factor, moving)
                push = 2.0 * at_speed(cells.speed_constant, moving)
            friction += cells.offset[i]
            growth, drive = 0.0, 0.0
            for p in range(n_powers - 1, -1, -1):
                growth = growth * friction + cells.growth[i, p]
                drive = drive * friction + cells.drive[i, p]
            step = (growth - 1.0) * moving + drive - push * cells.length[i]
            square[k + 1, j] = square[k, j] + step
    return square
