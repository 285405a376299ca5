"""How often avalanches run past a place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avahazard.hazard.avalanches import Avalanches, rate_below, yearly_rate
from avahazard.hazard.thresholds import stop_thresholds
from avahazard.physics.block import LEFT_PROFILE

Floats = NDArray[np.float64]

N_PLACES = 4001


def passing_rate(avalanches: Avalanches) -> Callable[[Floats], Floats]:
    """A function of x (m) `[n_parameters]`: the yearly rate of avalanches that stop beyond.

    What leaves the profile passes its end.
    """
    if avalanches.sigma_m is not None:
        chance = _passing_in_metres(avalanches)
        return lambda x: yearly_rate(avalanches, chance(x))
    find = stop_thresholds(avalanches)
    return lambda x: rate_below(avalanches, find(x))


def _passing_in_metres(avalanches: Avalanches) -> Callable[[Floats], Floats]:
    """Chances `[n_parameters, n_classes, n_volumes]` to stop beyond x `[n_parameters]`.

    Stops are at the block's elevation + sigma z, at the first place so low (`scattered_stops`).
    """
    assert avalanches.sigma_m is not None
    smooth = avalanches.site.smooth
    x = np.linspace(smooth.x_min, smooth.x_max, N_PLACES)
    lowest = np.minimum.accumulate(smooth.height(x))
    # On a counter-slope nothing stops: what is below the floor lies on it.
    floor = float(x[np.argmin(lowest)])
    ends_lowest = floor == x[-1]
    stop = _stop_elevation(avalanches)
    sigma = avalanches.sigma_m[:, None, None]

    def chance(place: Floats) -> Floats:
        height = np.interp(place, x, lowest)[:, None, None]
        stays = np.zeros_like(height, dtype=bool) | (not ends_lowest)
        stays &= place[:, None, None] >= floor
        with np.errstate(invalid="ignore"):
            passes = ndtr((height - stop) / sigma)
        return np.where(np.isneginf(stop), 1.0, np.where(stays, 0.0, passes))

    return chance


def _stop_elevation(avalanches: Avalanches) -> Floats:
    """Elevation of the block's stop at the friction of each volume, -inf where it left."""
    mu = np.exp(avalanches.location) if avalanches.in_log else avalanches.location
    result = np.empty_like(mu)
    for g, table in enumerate(avalanches.tables):
        mine = np.flatnonzero(avalanches.group == g)
        for c in range(avalanches.n_classes):
            _, height, status = table.curve[c].at(mu[mine, c].ravel())
            found = np.where(status == LEFT_PROFILE, -np.inf, height)
            result[mine, c] = found.reshape(len(mine), -1)
    return result
