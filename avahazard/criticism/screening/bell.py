"""The bell about what a model expects, within which a likelihood must be right.

A record on flat ground, or of a block that an effect holds back whatever its friction, says that
friction is below some value and no more. The mean and the variance of such a likelihood are those
of a normal that lets in what it rules out: of 20,000 events cohesion of 2.2 m/s² gained 11 nats
that way, and loses 367. So moments are taken of the likelihood times a bell where friction is
expected, and the bell is taken out of them (a step of expectation propagation, Minka 2001).
"""

from __future__ import annotations

import numpy as np

from avahazard.kernels import kernel

WIDTH = 0.5
"""Standard deviation of the bell, in log friction: some times the scatter of friction."""
FLATTEST = 0.1
"""Least precision of what is left: what is flatter tells nothing."""


@kernel(inner=True)
def bell_of(about):  # type: ignore[no-untyped-def]
    """Where the bell stands, and the inverse of its width; 0 and 0 for none (nan)."""
    if np.isnan(about):
        return 0.0, 0.0
    return about, 1.0 / WIDTH


@kernel(inner=True)
def without_bell(mean, variance, log_mass, about):  # type: ignore[no-untyped-def]
    """The moments of a likelihood which, times the bell `about` a log friction, has these."""
    if np.isnan(about):
        return mean, variance, log_mass
    own = 1.0 / max(1.0 / variance - WIDTH**-2, FLATTEST)
    place = mean + (mean - about) * own / WIDTH**2
    both = own + WIDTH**2
    lost = 0.5 * np.log(both / WIDTH**2) + 0.5 * (place - about) ** 2 / both
    return place, own, log_mass + lost
