"""Speeds of an avalanche whose friction, on the mean of its way, brings it to rest at a place.

Where F jumps no block with one friction stops, and yet avalanches do: their friction goes up and
down. With its mean the block of `block.run` would stop before it is there; here it is carried on
(u² below zero, and then no force but gravity and friction), so that work along the whole way is
that of the mean friction.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.cells import Cells
from avahazard.physics.resistance import SPEEDS

TRIED = np.linspace(0.0, 2.0, 81)
"""Frictions between which the mean is sought; between two of them u² goes nearly straight."""


def squares_to_rest(cells: Cells, start: int, stop_x: float, x: Floats) -> Floats:
    """u² (m²/s²) at the places x `[n_x]` of what starts at node `start` and rests at `stop_x`."""
    node_x = cells.x[start:]
    square = carried(cells, start, TRIED)
    at_stop = np.array([np.interp(stop_x, node_x, one) for one in square.T])
    places = np.array([np.interp(x, node_x, one, left=0.0) for one in square.T])
    # More friction, less speed.
    k = int(np.clip(np.searchsorted(-at_stop, 0.0), 1, len(TRIED) - 1))
    share = np.clip(at_stop[k - 1] / max(at_stop[k - 1] - at_stop[k], 1e-12), 0.0, 1.0)
    return np.asarray((1.0 - share) * places[k - 1] + share * places[k])


def carried(cells: Cells, start: int, mu: Floats) -> Floats:
    """u² at the nodes from `start` on, carried on below zero, `[n_nodes, n_friction]`."""
    n_cells = len(cells.length)
    square = np.zeros((n_cells + 1 - start, len(mu)))
    powers = np.arange(cells.growth.shape[1])
    for k, i in enumerate(range(start, n_cells)):
        moving = np.maximum(square[k], 0.0)
        friction = mu * cells.factor[i]
        push = 0.0
        if cells.speed_dependent:
            speed = np.sqrt(moving)
            friction = friction * np.interp(speed, SPEEDS, cells.speed_factor)
            push = 2.0 * np.interp(speed, SPEEDS, cells.speed_constant)
        term = (friction + cells.offset[i])[:, None] ** powers
        step = (term @ cells.growth[i] - 1.0) * moving + term @ cells.drive[i]
        square[k + 1] = square[k] + step - push * cells.length[i]
    return square
