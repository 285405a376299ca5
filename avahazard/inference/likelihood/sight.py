"""Which stops are seen, by friction.

A declared limit is of places: what stops above it is not seen, wherever its record would have put
it, and records lie above it by their errors alone. So it is an edge of friction, on either side of
which all is seen or nothing: of the record's likelihood the part below the edge counts, over the
chance to be below it (`hidden_from`). Were the chance taken of records instead, records above the
limit would be impossible in part, and friction be driven up without end.

A limit that is estimated lies at the highest record or above, and is one of records: a stop is
seen by the chance that its record lies below (`edges_of_sight`).
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.inference.likelihood.gauss_quadrature import gauss_nodes
from avahazard.inference.likelihood.panels import panel_nodes
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.friction_scatter import normal_below
from avahazard.inference.model.observations import Observations
from avahazard.kernels import kernel
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU

FEW = 4
"""Nodes of an edge of sight no wider than the least scatter: chances over 1 % err by 3 % at most
even for that, by 0.03 % for twice it. Each costs a normal probability at every evaluation."""


def hidden_from(observations: Observations, predicted: Predicted, in_log: bool = True) -> Floats:
    """Friction `[n_events]`, or its log, from which on stops lie above the declared limit.

    inf where all are seen, or no limit is declared; the lowest of the tables where none is.
    """
    edge = np.full(observations.n_events, np.inf)
    grid = np.log(MU) if in_log else MU
    limited = np.flatnonzero(np.isfinite(observations.limit))
    for i, broken in zip(limited, predicted.curve[limited].broken, strict=True):
        elevation = predicted.elevation[i] - predicted.raised[i]
        left = predicted.status[i] == LEFT_PROFILE
        if np.isfinite(elevation).any():
            edge[i] = _highest_seen(elevation, left, observations.limit[i], grid, broken)
    return edge


def _highest_seen(
    elevation: Floats, left: Bools, limit: float, grid: Floats, broken: Bools
) -> float:
    """The highest friction at which a stop is seen; inf where that is the highest of the grid.

    Seen is what stops below the limit, and all that goes further than such a stop: what runs up
    the other side of a valley is no short runout. Between two frictions stops are spread evenly,
    but for a `broken` cell, in each half of which its end holds, as where stops are looked up.
    """
    seen = np.flatnonzero(left | (elevation <= limit))
    if not len(seen):
        return float(grid[0])
    j = int(seen[-1])
    if j == len(grid) - 1:
        return float(np.inf)
    low, high = elevation[j], elevation[j + 1]
    # The end of a profile may itself lie above the limit.
    share = 0.5 if broken[j] or low > limit else (limit - low) / (high - low)
    return float(grid[j] + share * (grid[j + 1] - grid[j]))


@kernel(inner=True)
def edges_of_sight(elevation, left, limit, sigma, grid, panels, finest, place, weight):  # type: ignore[no-untyped-def]
    """P(seen) = w₀ + Σ w_k P(ν < ν_k) by records, with error `sigma`; returns w₀.

    It falls as friction rises, all that goes further than what is seen being seen, too: so no
    weight is negative.
    """
    n = len(grid)
    chance = np.empty(n)
    furthest = 0.0
    for j in range(n - 1, -1, -1):
        below = 1.0 if left[j] else normal_below((limit - elevation[j]) / sigma)
        furthest = max(furthest, below)
        chance[j] = furthest
    points = np.empty(n)
    drops = np.empty(n)
    count = 0
    level = 1.0
    for j in range(n):
        if level - chance[j] > 1e-9:
            points[count] = grid[j] if j == 0 else 0.5 * (grid[j - 1] + grid[j])
            drops[count] = level - chance[j]
            level = chance[j]
            count += 1
    if count:
        edges, chances = points[:count], drops[:count] / (1.0 - level)
        away = edges - np.sum(chances * edges)
        if np.sqrt(np.sum(chances * away * away)) <= 2.0 * finest:
            gauss_nodes(edges, chances, place[:FEW], weight[:FEW])
        else:
            panel_nodes(edges, chances, panels, place, weight)
        weight *= 1.0 - level
    return level
