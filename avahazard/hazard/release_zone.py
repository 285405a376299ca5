"""Where avalanches of a path start: a Beta distribution along its release zone.

After Eckert, Parent and others (2007 on), who draw the release from the records' distribution.
What spreads recorded releases is nature and the error of the records: avalanches to come have
the spread without the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats

ENOUGH_RELEASES = 5
LEAST_SPREAD_M = 20.0
"""Recorded releases within this range are taken for one place."""
N_RELEASES = 8


@dataclass(frozen=True, slots=True)
class ReleaseZone:
    """Elevations from `low_m` to `high_m`, Beta(a, b) between them; from `n` records.

    Over the top of a profile stands for its top.
    """

    low_m: float
    high_m: float
    a: float
    b: float
    n: int

    def elevations(self, n: int = N_RELEASES) -> Floats:
        """Elevations (m) `[n]` in the middle of n equally probable parts, lowest first."""
        from scipy.stats import beta  # noqa: PLC0415 (slow)

        share = beta.ppf((np.arange(n) + 0.5) / n, self.a, self.b)
        return np.asarray(self.low_m + (self.high_m - self.low_m) * share)


def release_zone(
    elevations: Floats, top_m: float, sigma: Floats | float = 0.0
) -> ReleaseZone | None:
    """Fit the zone to recorded releases (m) `[n]` of a path whose top is at `top_m`.

    `sigma` `[n]` (m) are their errors, of which they are freed first (`without_error`).
    The zone reaches the mean spacing of the records past their lowest and highest, the top at
    most; a and b are those with the mean and variance of the records. None with under 5
    records or where they spread over less than 20 m: then the path's own release is the one.
    """
    n = len(elevations)
    if n < ENOUGH_RELEASES or np.ptp(elevations) < LEAST_SPREAD_M:
        return None
    elevations = without_error(elevations, sigma)
    spacing = float(np.ptp(elevations)) / (n - 1)
    low = float(np.min(elevations)) - spacing
    high = min(float(np.max(elevations)) + spacing, max(top_m, float(np.max(elevations))))
    share = (np.asarray(elevations) - low) / (high - low)
    mean, variance = float(np.mean(share)), float(np.var(share, ddof=1))
    # Beta's variance is under mean (1 - mean): at the limit all mass lies at the ends.
    strength = max(mean * (1.0 - mean) / variance - 1.0, 0.1)
    return ReleaseZone(low, high, mean * strength, (1.0 - mean) * strength, n)


def without_error(elevations: Floats, sigma: Floats | float) -> Floats:
    """Recorded releases (m) `[n]` drawn towards their mean, so that they spread as the true ones.

    The true variance is that of the records less the mean square of their errors, at least that
    of one place.
    """
    mean, recorded = float(np.mean(elevations)), float(np.var(elevations, ddof=1))
    error = float(np.mean(np.square(sigma)))
    true = max(recorded - error, LEAST_SPREAD_M**2 / 12.0)
    return np.asarray(mean + np.sqrt(min(true / recorded, 1.0)) * (elevations - mean))


def stated_zone(elevation_m: float, sigma_m: float) -> ReleaseZone | None:
    """The zone that a path states: any place as likely, of that mean and standard deviation (m).

    None where it is one place.
    """
    side = float(np.sqrt(3.0)) * sigma_m
    if 2.0 * side < LEAST_SPREAD_M:
        return None
    return ReleaseZone(elevation_m - side, elevation_m + side, 1.0, 1.0, 0)
