"""Posterior draws of how often avalanches over a volume come: by a GEV, or over a threshold.

The sign of the shape is that of `scipy.stats.genextreme`: positive has an upper bound, negative a
heavy tail.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from scipy import stats
from scipy.ndimage import gaussian_filter
from scipy.special import gamma, logsumexp

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.terms import exp_memory, exponentials, logarithms
from avahazard.kernels import kernel


class Gev(NamedTuple):
    """Shape, location and scale of many distributions at once `[n]`, as `genextreme` takes them."""

    shape: Floats
    location: Floats
    scale: Floats


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

    def log_volume(self, chance: float | Floats) -> Floats:
        """Log volume `[n]` that a year's largest exceeds with this chance, one or `[n]`."""

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
        each = (part[:, None] for part in self.gev)
        exceeded = stats.genextreme.sf(log_volume, *each)
        return np.asarray(-np.log1p(-self.chance[:, None] * exceeded))

    def log_volume(self, chance: float | Floats) -> Floats:
        """p (1 - G(v)) = chance; where events are rarer, the smallest volumes."""
        share = np.minimum(chance / np.maximum(self.chance, 1e-12), 1.0 - RAREST)
        return np.asarray(stats.genextreme.isf(share, *self.gev))

    def ends(self) -> tuple[float, float]:
        """From the smallest of typical draws to the largest of wide ones."""
        low = float(np.quantile(stats.genextreme.ppf(BULK, *self.gev), 0.2))
        return low, float(np.quantile(stats.genextreme.isf(TAIL, *self.gev), 0.9))


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

    def log_volume(self, chance: float | Floats) -> Floats:
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


ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""
NODE_STEP = 0.15
MAX_NODES = 48
"""Nodes over log volume: about one for each 15 %."""


@dataclass(frozen=True, slots=True, eq=False)
class EventVolumes:
    """Posterior draws of the rate of avalanches and of the distribution of their volumes.

    `rate` `[n_parameters]` a year; `share` `[n_parameters, n_volumes]` of the avalanches have
    the volumes `log_volume` `[n_volumes]` (log m3, rising), and sum to 1. `seen_only`: they are
    those of the records, which lack what nobody saw.
    """

    rate: Floats
    log_volume: Floats
    share: Floats
    seen_only: bool = False


def one_volume(volume_m3: float, n_parameters: int, rate: float = 1.0) -> EventVolumes:
    """Avalanches of one volume at a known rate."""
    rates, share = np.full(n_parameters, rate), np.ones((n_parameters, 1))
    return EventVolumes(rates, np.array([np.log(volume_m3)]), share)


def event_volumes(
    rate: Floats, rate_over: Callable[[Floats], Floats], low: float, high: float
) -> EventVolumes:
    """Gather a frequency on nodes between two log volumes.

    `rate_over` maps log volumes `[n]` to the yearly rates of larger avalanches
    `[n_parameters, n]`; what lies past the ends counts at the end nodes.
    """
    n = int(np.clip(np.ceil((high - low) / NODE_STEP) + 1, 1, MAX_NODES))
    nodes = np.linspace(low, high, n)
    over = rate_over(0.5 * (nodes[1:] + nodes[:-1]))
    ends = np.zeros((len(rate), 1))
    over = np.minimum(np.hstack([rate[:, None], over, ends]), rate[:, None])
    with np.errstate(invalid="ignore", divide="ignore"):
        share = -np.diff(np.minimum.accumulate(over, axis=1), axis=1) / rate[:, None]
    # A rate of zero has no volumes: any will do.
    share[rate <= 0.0] = 1.0 / n
    return EventVolumes(rate, nodes, share)


def with_volumes(volumes: EventVolumes, log_volume: Floats) -> EventVolumes:
    """The same with nodes at more log volumes, which have no share."""
    more = np.setdiff1d(log_volume, volumes.log_volume)
    nodes = np.concatenate([volumes.log_volume, more])
    share = np.hstack([volumes.share, np.zeros((len(volumes.rate), len(more)))])
    order = np.argsort(nodes)
    return replace(volumes, log_volume=nodes[order], share=share[:, order])


def annual_rate(return_period_years: float) -> float:
    """The yearly rate at which a year has one or more with chance 1/T: -log(1 - 1/T); T > 1."""
    return float(-np.log1p(-1.0 / return_period_years))


LOG_SCALES = np.array([-2.6 + 0.07 * k for k in range(61)])
"""Grid of the log of the scale, `[n_scales]`."""
SHAPES = np.array([-0.475 + 0.05 * k for k in range(27)])
"""Grid of the shape in the sign of `scipy.stats.genextreme`, `[n_shapes]`: positive has an upper
bound. Zero is between two of its points."""
MEAN_OFFSET = (1.0 - gamma(1.0 + SHAPES)) / SHAPES
"""Mean less location of a GEV, in scales, `[n_shapes]`."""
STANDARD_DEVIATION = np.sqrt(gamma(1.0 + 2.0 * SHAPES) - gamma(1.0 + SHAPES) ** 2) / np.abs(SHAPES)
"""Of a GEV, in scales, `[n_shapes]`."""
DEVIATIONS = np.linspace(-5.0, 5.0, 33)
"""Grid of the mean about the sample's, in standard errors, `[n_locations]`."""
LEAST_INSIDE = 1e-300
"""Stands for what is 0 or less, where a maximum is impossible, until all is summed."""
SPREAD = 1.3
"""Standard deviation of a GEV near shape 0, in scales."""
SHAPE_CENTRE, SHAPE_SD = 0.2, 0.15
"""Weak prior of the shape, normal. Lognormal volumes have logs of shape near 0.28, volumes with a
Pareto tail 0; a bound by the snow of the release zone is a larger shape."""
BETWEEN_SCALE, BETWEEN_SHAPE = 0.2, 0.1
"""How far paths of one region differ in log scale and in shape (standard deviations)."""


def shape_prior(error: float = 0.0) -> Floats:
    """Log prior density `[n_scales, n_shapes]`: flat in log scale, normal in the shape.

    Where records have an `error` (sd), it is flat in the log of the scale with which they spread:
    flat in that of what lies under it, it would let the error be all there is.
    """
    row: Floats = -0.5 * ((SHAPES - SHAPE_CENTRE) / SHAPE_SD) ** 2
    return np.asarray(row + 2.0 * (LOG_SCALES[:, None] - with_error(error)))


def with_error(error: float) -> Floats:
    """Log scale `[n_scales, n_shapes]` with which records spread whose errors have this sd."""
    square = np.exp(2.0 * LOG_SCALES)[:, None] + (error / STANDARD_DEVIATION) ** 2
    return np.asarray(0.5 * np.log(square))


def regional_prior(others: Floats, error: float = 0.0) -> Floats:
    """Log prior `[n_scales, n_shapes]` of a path in the light of other paths.

    `others` is the sum of their log likelihoods over the grid. Their common scale and shape are
    known from all together; the path's own differ from these by `BETWEEN_SCALE` and
    `BETWEEN_SHAPE`. `error` as in `shape_prior`.
    """
    together = shape_prior(error=error) + others
    density = np.exp(together - logsumexp(together))
    steps = (BETWEEN_SCALE / np.diff(LOG_SCALES)[0], BETWEEN_SHAPE / np.diff(SHAPES)[0])
    blurred = gaussian_filter(density, steps, mode="nearest")
    return np.asarray(np.log(np.maximum(blurred, 1e-300)))


def gev_likelihood(sample: Floats, error: float = 0.0) -> Floats:
    """Log likelihood `[n_scales, n_shapes, n_locations]` of maxima `[n]` recorded with an `error`.

    With normal errors of that sd they are taken for a GEV of the same mean and shape that spreads
    by both (`with_error`).
    """
    centred = sample - sample.mean()
    grids = (with_error(error), SHAPES, _locations(len(sample)))
    return np.asarray(_gev_likelihood(centred, *grids))


@kernel
def _gev_likelihood(centred, log_scales, shapes, locations):  # type: ignore[no-untyped-def]
    n, n_locations = len(centred), locations.shape[1]
    result = np.full((len(log_scales), len(shapes), n_locations), -np.inf)
    inside, smallest = np.empty(n * n_locations), np.empty(n_locations)
    bits, memory = inside.view(np.int64), exp_memory(n * n_locations)
    for i in range(len(log_scales)):
        for k in range(len(shapes)):
            shape, total = shapes[k], result[i, k]
            scaled = centred * math.exp(-log_scales[i, k])
            # A flat prior of the location in log m3 is one of the grid's times the scale.
            total[:] = -(n - 1) * log_scales[i, k]
            smallest[:] = np.inf
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    value = 1.0 - shape * (scaled[j] - locations[k, m])
                    smallest[m] = min(smallest[m], value)
                    row[m] = max(value, LEAST_INSIDE)
            if not np.any(smallest > 0.0):
                total[:] = -np.inf
                continue
            # log, then exp, of all at once.
            logarithms(inside, bits, len(inside), memory)
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    total[m] += (1.0 / shape - 1.0) * row[m]
                    row[m] = min(row[m] / shape, 700.0)
            exponentials(inside, len(inside), memory)
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    total[m] -= row[m]
            for m in range(n_locations):
                if smallest[m] <= 0.0:
                    total[m] = -np.inf
    return result


def gev_draws(
    sample: Floats,
    prior: Floats,
    likelihood: Floats,
    n: int,
    rng: np.random.Generator,
    *,
    error: float = 0.0,
    middle: float | None = None,
) -> Gev:
    """Draws `[n]` of the GEV of true maxima, from the `gev_likelihood` of `sample` and a log prior.

    `sample` `[n_maxima]` was recorded with `error`. The largest record of a year owes it to its
    error too: the draws lie nearer to `middle`, the mean of all records, by as much as these
    spread more than true ones.
    """
    i, k, m = _cells(likelihood + prior[:, :, None], n, rng)
    scale = np.exp(_spread(LOG_SCALES, i, rng))
    wider = np.exp(with_error(error)[i, k] - LOG_SCALES[i])
    grid = _locations(len(sample))
    step = (grid[0, 1] - grid[0, 0]) * rng.uniform(-0.5, 0.5, n)
    centre = sample.mean()
    if middle is not None:
        centre = centre - (1.0 - 1.0 / wider) * (centre - middle)
    # The mean stays; the location is that of a smaller scale.
    place = (grid[k, m] + step) * wider + (wider - 1.0) * MEAN_OFFSET[k]
    return Gev(_spread(SHAPES, k, rng), centre + place * scale, scale)


def gpd_likelihood(excess: Floats) -> Floats:
    """Log likelihood `[n_scales, n_shapes]` of excesses `[n]` over a threshold."""
    scales = np.exp(LOG_SCALES)[:, None, None]
    each = stats.genpareto.logpdf(excess, -SHAPES[:, None], scale=scales)
    return np.asarray(np.sum(each, axis=-1))


def gpd_draws(
    prior: Floats, likelihood: Floats, n: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Draws `[n]` of scale and shape (sign as `SHAPES`) of the excesses."""
    i, k = _cells(likelihood + prior, n, rng)
    return np.exp(_spread(LOG_SCALES, i, rng)), _spread(SHAPES, k, rng)


def over_locations(likelihood: Floats) -> Floats:
    """The log likelihood of scale and shape alone `[n_scales, n_shapes]`."""
    largest = np.maximum(likelihood.max(axis=-1), -1e300)  # a third of the time of logsumexp
    with np.errstate(divide="ignore"):
        summed = np.log(np.exp(likelihood - largest[..., None]).sum(axis=-1))
    return np.asarray(largest + summed)


def _locations(n: int) -> Floats:
    """Location less the mean of a sample of n, in scales, `[n_shapes, n_locations]`."""
    return np.asarray(DEVIATIONS * SPREAD / np.sqrt(n) - MEAN_OFFSET[:, None])


def _cells(log_density: Floats, n: int, rng: np.random.Generator) -> tuple[Ints, ...]:
    """Grid indices of draws, an array `[n]` for each axis."""
    flat = log_density.ravel()
    weight = np.exp(flat - flat.max())
    drawn = rng.choice(len(flat), size=n, p=weight / weight.sum())
    return tuple(np.asarray(axis) for axis in np.unravel_index(drawn, log_density.shape))


def _spread(grid: Floats, index: Ints, rng: np.random.Generator) -> Floats:
    """Values about the points of a uniform grid, within half a step."""
    return np.asarray(grid[index] + (grid[1] - grid[0]) * rng.uniform(-0.5, 0.5, len(index)))
