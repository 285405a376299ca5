"""Speeds of an avalanche whose friction, on the mean of its way, brings it to rest at a place.

Where F jumps no block with one friction stops, and yet avalanches do: their friction goes up and
down. With its mean the block of `block.run` would stop before it is there; here it is carried on
(u² below zero, and then no force but gravity and friction), so that work along the whole way is
that of the mean friction.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.cell_motion import at_speed
from avahazard.physics.cells import Cells

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
