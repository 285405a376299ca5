"""The likelihood p(record | μ) of a runout length without a profile: L = H/μ, exactly.

No table of F is needed on the energy line, so that any friction can be told: the points lie where
the record is, from H/L = 0.001 of a slide on the sea floor to the steepest fall.
"""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.panels import panel_nodes
from avahazard.inference.likelihood.record_density import LEAST_TAIL
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

REACH = 7.0
"""Lengths farther than this many standard deviations from the record say nothing about μ."""
STEEPEST = 3.0
"""Friction up to which a record that tells next to nothing is followed."""
STEP, FEWEST, N_POINTS = 0.02, 128, 512
"""Step in log μ, and the fewest and most points."""
SUM_STEP, FEWEST_OF_SUM = 0.04, 32
"""The same for sums over a bump that is whole: equal steps up to 0.9 of its standard deviation err
by less than 1e-9."""


@kernel
def straight_points(height, observed, sigma, in_log, for_sums, points, logs):  # type: ignore[no-untyped-def]
    """Points in ν = log μ, or in μ, and the log mass of the likelihood at each; returns how many.

    `points`, `logs` have room for `N_POINTS`. `height` is the height of fall H, `observed` the
    runout length with error `sigma`, all in m. Fewer points will do `for_sums` alone.
    """
    shortest = height / STEEPEST
    if observed > 0.0:
        shortest = min(shortest, 0.5 * observed)
    low = max(observed - REACH * sigma, shortest)
    high = observed + REACH * sigma
    if high <= low:  # a made record below zero tells no more than that it is short
        high = 2.0 * low
    span = np.log(high) - np.log(low)
    count = int(min(max(np.ceil(span / STEP), FEWEST), N_POINTS))
    if for_sums and low > shortest:
        count = int(min(max(np.ceil(span / SUM_STEP), FEWEST_OF_SUM), N_POINTS))
    step = span / count
    for k in range(count):
        place = np.log(height / high) + (k + 0.5) * step
        z = (height * np.exp(-place) - observed) / sigma
        logs[k] = np.log(step) - 0.5 * z * z - np.log(sigma) - HALF_LOG_2PI
        points[k] = place
        if not in_log:
            points[k] = np.exp(place)
            logs[k] += place
    return count


@kernel
def straight_density_nodes(height, observed, sigma, in_log, panels, place, weight, tail):  # type: ignore[no-untyped-def]
    """Nodes of p(record | μ) as in `panels`; returns the log of its total mass and the last place.

    `tail` `[2]` is filled with p(record | μ) before all places (none) and beyond the last, where
    it is that of a block which goes nowhere, as shares of the total mass.
    """
    points, logs = np.empty(N_POINTS), np.empty(N_POINTS)
    count = straight_points(height, observed, sigma, in_log, False, points, logs)
    points, logs = points[:count], logs[:count]
    top = np.max(logs)
    masses = np.exp(logs - top)
    panel_nodes(points, masses, panels, place, weight)
    log_total = top + np.log(np.sum(masses))
    tail[:] = 0.0
    z = observed / sigma
    share = np.exp(-0.5 * z * z - np.log(sigma) - HALF_LOG_2PI - log_total)
    if share > LEAST_TAIL:
        tail[1] = share
    return log_total, points[-1]
