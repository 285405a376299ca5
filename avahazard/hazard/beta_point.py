"""The β-point, where a path flattens to 10° for good, and what AvaFrame asks for instead."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats

BETA_SLOPE_DEG = 10.0
FLAT_SLOPE = float(np.tan(np.radians(BETA_SLOPE_DEG)))
SHORTEST_RUNOUT_ZONE_M = 100.0
"""A bench shorter than this is no runout zone: real tracks have many of 30 to 50 m."""
AVAFRAME_STEP_M = 10.0
AVAFRAME_FLAT_M = 30.0
"""Longest step of com2AB, and the flat length below its β-point."""


def lasting_flats(x: Floats, steepness: Floats) -> Floats:
    """Places (m) where the path flattens to 10° for a runout zone's length, from the top down."""
    excess = steepness - FLAT_SLOPE
    flat = excess <= 0.0

    def crossings(j: NDArray[np.intp]) -> Floats:
        share = excess[j] / (excess[j] - excess[j + 1])
        return np.asarray(x[j] + share * (x[j + 1] - x[j]))

    falls = crossings(np.flatnonzero(~flat[:-1] & flat[1:]))
    ends = np.append(crossings(np.flatnonzero(flat[:-1] & ~flat[1:])), np.inf)
    ends = ends[np.searchsorted(ends, falls)]
    return np.asarray(falls[ends - falls >= SHORTEST_RUNOUT_ZONE_M])
