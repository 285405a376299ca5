"""The runout exceeded once in T years, and what varies naturally apart from what is not known."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.avalanches import Avalanches, annual_rate
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.passing import passing, path_ends
from avahazard.hazard.runout_bounds import QUANTILES, spread
from avahazard.results.hazard import RunoutInterval

N_LEVELS = 199
"""Probabilities at which the natural variability is followed."""
N_PLACES = 60


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """Annual chance of reaching places: `x`, `elevation` (m), `chance` `[n_places, 3]`.

    The three are its 5, 50 and 95 % over the uncertainty of the parameters.
    """

    x: Floats
    elevation: Floats
    chance: Floats


def exceeded_runout(avalanches: Avalanches, return_period_years: float) -> Floats:
    """x (m) `[n_parameters]` that a year's avalanches pass with chance 1/T; inf past the end.

    All volumes, frictions and releases are mixed, at the rate of the path, within each draw of
    the parameters: λ P(X > x) = -log(1 - 1/T).
    """
    return passing(avalanches).exceeded(annual_rate(return_period_years))


def middle_runout(avalanches: Avalanches) -> Floats:
    """The median runout x (m) `[n_parameters]` of the avalanches of each draw of the parameters."""
    return passing(avalanches).exceeded(0.5 * avalanches.volumes.rate)


def natural_runouts(avalanches: Avalanches) -> Floats:
    """Runouts x (m) `[n_levels]` at even probabilities, all parameters at their middle."""
    middle = at_the_middle(avalanches)
    level = 1.0 - (np.arange(N_LEVELS) + 0.5) / N_LEVELS
    return passing(middle).exceeded(level * middle.volumes.rate)


def reach(avalanches: Avalanches, n_places: int = N_PLACES) -> Reach:
    """Annual chance that one or more avalanches pass each of `n_places` places below the release.

    1 - exp(-λ P(X > x)), x evenly from the highest release to the end of the profile.
    """
    x = np.linspace(*path_ends(avalanches), n_places)
    rates = passing(avalanches).rates(x)
    found = np.quantile(-np.expm1(-rates), QUANTILES, axis=1).T
    return Reach(x, np.asarray(avalanches.site.smooth.height(x)), found)


def at_volume(avalanches: Avalanches, log_volume: Floats) -> Avalanches:
    """The same path with one volume for each draw (log m3) `[n_parameters]`, once a year.

    Friction is interpolated between the volumes of `avalanches`.
    """
    nodes = avalanches.volumes.log_volume
    n = avalanches.n_parameters
    if len(nodes) == 1:
        k, part = np.zeros(n, np.int64), np.zeros(n)
    else:
        place = np.interp(log_volume, nodes, np.arange(len(nodes)))
        k = np.minimum(place.astype(np.int64), len(nodes) - 2)
        part = place - k
    draw = np.arange(n)

    def between(values: Floats) -> Floats:
        after = values[draw, :, np.minimum(k + 1, len(nodes) - 1)]
        return np.asarray(values[draw, :, k] * (1 - part)[:, None] + after * part[:, None])

    return replace(
        avalanches,
        volumes=EventVolumes(np.ones(n), np.zeros(1), np.ones((n, 1))),
        location=between(avalanches.location)[:, :, None],
        scatter=between(avalanches.scatter)[:, :, None],
    )


def at_the_middle(avalanches: Avalanches) -> Avalanches:
    """The same path with one draw: rate, shares, friction and tables at their medians."""

    def middle(values: Floats) -> Floats:
        return np.asarray(np.median(values, axis=0, keepdims=True))

    share = middle(avalanches.volumes.share)
    share /= share.sum(axis=1, keepdims=True)
    return replace(
        avalanches,
        volumes=EventVolumes(middle(avalanches.volumes.rate), avalanches.volumes.log_volume, share),
        location=middle(avalanches.location),
        scatter=middle(avalanches.scatter),
        group=avalanches.group[[avalanches.n_parameters // 2]],
        sigma_m=None if avalanches.sigma_m is None else middle(avalanches.sigma_m),
    )


def runout_interval(avalanches: Avalanches, x: Floats, interval: str) -> RunoutInterval:
    """Mean and quantiles of runouts x (m) `[n]`, inf beyond the profile, and their elevations.

    `interval` says what varies among them.
    """
    smooth = avalanches.site.smooth
    inside = np.isfinite(x)
    height = np.where(inside, smooth.height(np.where(inside, x, smooth.x_max)), -np.inf)
    return RunoutInterval(spread(x), spread(height), interval)
