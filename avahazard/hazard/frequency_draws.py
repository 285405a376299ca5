"""Posterior draws of how often avalanches over a volume come: by a GEV, or over a threshold.

The sign of the shape is that of `scipy.stats.genextreme`: positive has an upper bound, negative a
heavy tail.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy import stats
from scipy.special import expm1, log1p

from avahazard.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Gev:
    """Shape, location and scale of many distributions at once, arrays `[n]`."""

    shape: Floats
    location: Floats
    scale: Floats

    def quantile(self, probability: float | Floats) -> Floats:
        """Value `[n]` that a maximum stays under with the given probability over 0."""
        reduced, shape = -np.log(-np.log(probability)), _nonzero(self.shape)
        return np.asarray(-expm1(-shape * reduced) / shape * self.scale + self.location)

    def exceedance(self, values: Floats) -> Floats:
        """Chance `[n, n_values]` that a maximum is over each of `values`."""
        shape = _nonzero(self.shape)[:, None]
        scaled = (values - self.location[:, None]) / self.scale[:, None]
        with np.errstate(divide="ignore", over="ignore"):
            # 1 is the bound: none is over it with a positive shape, all are with a negative one.
            reduced = -log1p(-np.minimum(shape * scaled, 1.0)) / shape
            return np.asarray(-expm1(-np.exp(-reduced)))


def _nonzero(shape: Floats) -> Floats:
    """The shape, next to nought where it is nought: so the formulas hold to the last digits."""
    return np.where(shape == 0.0, 1e-12, shape)


BULK, TAIL = 0.002, 1e-4
"""Shares of the smallest and the largest avalanches that lie past the ends of the nodes."""
RAREST = 1e-3


class FrequencyDraws(Protocol):
    """Draws `[n]` of one path's frequency; log volumes in log m3, rates a year."""

    @property
    def rate(self) -> Floats:
        """Yearly rate of avalanches `[n]`."""

    def rate_over(self, log_volume: Floats) -> Floats:
        """Rates `[n, n_volumes]` of avalanches over each log volume `[n_volumes]`."""

    def log_volume(self, chance: float) -> Floats:
        """Log volume `[n]` that a year's largest exceeds with this chance."""

    def ends(self) -> tuple[float, float]:
        """Log volumes between which nearly all avalanches lie."""


@dataclass(frozen=True, slots=True, eq=False)
class GevDraws:
    """A year has avalanches with `chance` `[n]`, the largest of them as `gev` (of log m3)."""

    chance: Floats
    gev: Gev

    @property
    def rate(self) -> Floats:
        """Rate of avalanches: that of a Poisson process with this chance of a year with any."""
        return np.asarray(-np.log1p(-self.chance))

    def rate_over(self, log_volume: Floats) -> Floats:
        """Of a Poisson process whose yearly maxima these are: -log(1 - p (1 - G(v)))."""
        return np.asarray(-np.log1p(-self.chance[:, None] * self.gev.exceedance(log_volume)))

    def log_volume(self, chance: float) -> Floats:
        """p (1 - G(v)) = chance; where events are rarer, the smallest volumes."""
        share = np.minimum(chance / np.maximum(self.chance, 1e-12), 1.0 - RAREST)
        return self.gev.quantile(1.0 - share)

    def ends(self) -> tuple[float, float]:
        """From the smallest of typical draws to the largest of wide ones."""
        low = float(np.quantile(self.gev.quantile(BULK), 0.2))
        return low, float(np.quantile(self.gev.quantile(1.0 - TAIL), 0.9))


@dataclass(frozen=True, slots=True, eq=False)
class ThresholdDraws:
    """Avalanches over a threshold: Poisson, their excess of log volume a generalised Pareto.

    `rate` `[n]` a year, of which `share_over` exceed the log volume `threshold`; `scale`, `shape`
    `[n]` in the sign of `genextreme`. Below lie volumes `below` `[n_below]`, rising, with
    `weight` `[n, n_below]` (the Bayesian bootstrap).
    """

    rate: Floats
    share_over: Floats
    threshold: float
    scale: Floats
    shape: Floats
    below: Floats
    weight: Floats

    def rate_over(self, log_volume: Floats) -> Floats:
        """Rate times the Pareto tail above the threshold, counts below it."""
        excess = np.maximum(log_volume - self.threshold, 0.0)
        tail = stats.genpareto.sf(excess[None, :], -self.shape[:, None], scale=self.scale[:, None])
        larger = self.weight @ (self.below[:, None] > log_volume[None, :]).astype(float)
        above = log_volume >= self.threshold
        share = np.where(above, 0.0, (1.0 - self.share_over[:, None]) * larger)
        share = share + self.share_over[:, None] * tail
        return np.asarray(self.rate[:, None] * share)

    def log_volume(self, chance: float) -> Floats:
        """Where the rate is that of years with one or more, -log(1 - chance)."""
        share = -np.log1p(-chance) / self.rate
        tail = np.minimum(share / self.share_over, 1.0)
        above = self.threshold + stats.genpareto.ppf(1.0 - tail, -self.shape, scale=self.scale)
        if not len(self.below):
            return np.asarray(above)
        # Under the threshold: the weights summed from the largest volume down.
        needed = (share - self.share_over) / np.maximum(1.0 - self.share_over, 1e-12)
        summed = np.cumsum(self.weight[:, ::-1], axis=1)
        k = np.minimum(np.sum(summed < needed[:, None], axis=1), len(self.below) - 1)
        return np.where(share > self.share_over, self.below[::-1][k], above)

    def ends(self) -> tuple[float, float]:
        """From the smallest record to the largest of wide draws."""
        far = stats.genpareto.ppf(1.0 - TAIL, -self.shape, scale=self.scale)
        low = float(self.below[0]) if len(self.below) else self.threshold
        return low, self.threshold + float(np.quantile(far, 0.9))
