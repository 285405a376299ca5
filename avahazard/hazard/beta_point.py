"""The β-point, where a path flattens to 10°, by two definitions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile

BETA_SLOPE_DEG = 10.0
SHORTEST_RUNOUT_ZONE_M = 100.0
"""A bench shorter than this is no runout zone: real tracks have many of 30 to 50 m."""
AVAFRAME_STEP_M = 10.0
AVAFRAME_FLAT_M = 30.0


def lasting_flats(x: Floats, steepness: Floats) -> Floats:
    """Places (m) where the path flattens to 10° for a runout zone's length, from the top down."""
    excess = steepness - np.tan(np.radians(BETA_SLOPE_DEG))
    flat = excess <= 0.0

    def crossings(j: NDArray[np.intp]) -> Floats:
        share = excess[j] / (excess[j] - excess[j + 1])
        return np.asarray(x[j] + share * (x[j + 1] - x[j]))

    falls = crossings(np.flatnonzero(~flat[:-1] & flat[1:]))
    ends = np.append(crossings(np.flatnonzero(flat[:-1] & ~flat[1:])), np.inf)
    ends = ends[np.searchsorted(ends, falls)]
    return np.asarray(falls[ends - falls >= SHORTEST_RUNOUT_ZONE_M])


def first_flat_step(smooth: SmoothProfile, release_x: float) -> float | None:
    """The end (m) of the first flat step of 10 m, as AvaFrame's com2AB has it; None without one.

    A step is flat if it falls by 10° at most; those of the 30 m below must be flat too. A release
    on flat ground is passed first, for which com2AB asks a split point of its user.
    """
    x, y = avaframe_points(smooth, release_x)
    flat = np.degrees(np.arctan2(-np.diff(y), np.diff(x))) <= BETA_SLOPE_DEG
    more = round(AVAFRAME_FLAT_M / AVAFRAME_STEP_M)
    if flat.all():
        return None
    first = int(np.argmin(flat))
    lasting = np.convolve(flat[first:], np.ones(1 + more), "valid") > more
    found = np.flatnonzero(lasting)
    return float(x[first + found[0] + 1]) if len(found) else None


def avaframe_points(smooth: SmoothProfile, release_x: float) -> tuple[Floats, Floats]:
    """x and y (m) every 10 m from the release on; the last step is shorter."""
    x = np.append(np.arange(release_x, smooth.x_max, AVAFRAME_STEP_M), smooth.x_max)
    return x, smooth.height(x)
