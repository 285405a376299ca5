"""The likelihood p(record | μ) of a runout length without a profile: L = H/μ, exactly.

No table of F is needed on the energy line, so that any friction can be told: the points lie where
the record is, from H/L = 0.001 of a slide on the sea floor to the steepest fall.
"""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.gauss_quadrature import gauss_nodes
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

REACH = 7.0
"""Lengths farther than this many standard deviations from the record say nothing about μ."""
STEEPEST = 3.0
"""Friction up to which a record that tells next to nothing is followed."""
N_POINTS = 128


@kernel
def straight_points(height, observed, sigma, in_log, points, logs):  # type: ignore[no-untyped-def]
    """Points `[N_POINTS]` in ν = log μ, or in μ, and the log mass of the likelihood at each.

    `height` is the height of fall H, `observed` the runout length with error `sigma`, all in m.
    """
    shortest = height / STEEPEST
    if observed > 0.0:
        shortest = min(shortest, 0.5 * observed)
    low = max(observed - REACH * sigma, shortest)
    high = observed + REACH * sigma
    if high <= low:  # a made record below zero tells no more than that it is short
        high = 2.0 * low
    step = (np.log(high) - np.log(low)) / N_POINTS
    for k in range(N_POINTS):
        place = np.log(height / high) + (k + 0.5) * step
        z = (height * np.exp(-place) - observed) / sigma
        logs[k] = np.log(step) - 0.5 * z * z - np.log(sigma) - HALF_LOG_2PI
        points[k] = place
        if not in_log:
            points[k] = np.exp(place)
            logs[k] += place


@kernel
def straight_density_nodes(height, observed, sigma, in_log, place, weight):  # type: ignore[no-untyped-def]
    """Nodes of p(record | μ); returns the log of its total mass."""
    points, logs = np.empty(N_POINTS), np.empty(N_POINTS)
    straight_points(height, observed, sigma, in_log, points, logs)
    top = np.max(logs)
    masses = np.exp(logs - top)
    gauss_nodes(points, masses, place, weight)
    return top + np.log(np.sum(masses))
