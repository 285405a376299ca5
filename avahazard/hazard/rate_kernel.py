"""Yearly rates of normal friction under thresholds, summed in one pass."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.friction_scatter import normal_below
from avahazard.kernels import kernel

Floats = NDArray[np.float64]

FAR = 8.5
"""Standard scatters past which the normal distribution is 0 or 1 to the last bit."""
NOTHING = 1e-8
"""A share of avalanches that does not count."""


@kernel
def chance_under(z):  # type: ignore[no-untyped-def]
    """Φ(z)."""
    if z < -FAR:
        return 0.0
    if z > FAR:
        return 1.0
    return normal_below(z)


@kernel
def normal_rates(mu, in_log, location, scatter, share, class_share, rate):  # type: ignore[no-untyped-def]
    """The rates `[n_parameters]` of `avalanches.rate_below`; arrays as in `Avalanches`."""
    n_parameters, n_classes, n_volumes = location.shape
    result = np.zeros(n_parameters)
    for p in range(n_parameters):
        total = 0.0
        for c in range(n_classes):
            if mu[p, c] <= 0.0:
                continue
            under = math.log(mu[p, c]) if in_log else mu[p, c]
            chance = 0.0
            for v in range(n_volumes):
                if share[p, v] < NOTHING:
                    continue
                m, s = location[p, c, v], scatter[p, c, v]
                here = chance_under((under - m) / s)
                if not in_log:
                    impossible = chance_under(-m / s)
                    here = (here - impossible) / max(1.0 - impossible, 1e-300)
                chance += share[p, v] * here
            total += class_share[c] * chance
        result[p] = rate[p] * total
    return result
