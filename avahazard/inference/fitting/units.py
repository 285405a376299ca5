"""Units of the coordinates in which modes are sought and differences taken."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.posterior import Posterior

STEEP = 100.0
"""Change of log friction per coordinate from which on a coordinate is too coarse to move in."""


def units(posterior: Posterior) -> Floats:
    """The unit of each coordinate `[n_slots]`, 1 where it is of order one as it should be.

    The n of the exponential law is so on paths of snow; with slides of 1e12 m3 its coordinate
    moves log friction by a million. There the unit is what moves it by one (root mean square).
    """
    law, volumes = posterior.layout.law, posterior.observations.volumes
    unit = np.ones(len(posterior.layout.slots))
    if not law.uses_volume or not volumes.population.known:
        return unit
    volume = np.exp(volumes.mean)
    middle = law.prior_mean
    for k in range(len(law.coordinates)):
        # Small enough that no law is at its bounds.
        step = np.zeros(len(middle))
        step[k] = 1e-12
        moved = law.log_friction(middle + step, volume) - law.log_friction(middle - step, volume)
        slope = float(np.sqrt(np.mean(np.square(moved / 2e-12))))
        if slope > STEEP:
            unit[k] = 1.0 / slope
    return unit
