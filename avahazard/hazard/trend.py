"""Trends of the rate of avalanches and of their volumes; rate and volumes as of a year."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy import stats

from avahazard.arrays import Floats, Ints
from avahazard.hazard.extremes import FrequencyDraws
from avahazard.hazard.volume_records import VolumeRecord
from avahazard.notes import Note

FEWEST_RECORDS, LEAST_WINTERS = 20, 10
"""Dated records, and winters with any, from which a trend is estimated."""
SIGNIFICANT = 0.01
"""Of each of the two tests: one of fifty data sets without a trend is said to have one."""
NODES = 400


@dataclass(frozen=True, slots=True)
class Slope:
    """Change of a logarithm from one decade to the next, its standard error and p-value."""

    mean: float
    se: float
    p_value: float

    def factors(self) -> dict[str, float]:
        """The change as a factor, with its 90 % interval."""
        ends = {"factor": 0.0, "low": -1.0, "high": 1.0}
        z = float(stats.norm.ppf(0.95))
        return {key: float(np.exp(self.mean + k * z * self.se)) for key, k in ends.items()}


@dataclass(frozen=True, slots=True)
class Trend:
    """How the rate of avalanches and their volumes change over the years, on all paths alike.

    `rate` is None with too few records, `size` with too few volumes. `first`, `last`: the years
    that any path was observed in.
    """

    rate: Slope | None
    size: Slope | None
    first: int
    last: int

    def notes(self, as_of: int | None) -> list[Note]:
        """Which trends the records show; with a year `as_of`, that these are followed to it."""
        if as_of is None:
            slopes = {"rate_trend": self.rate, "size_trend": self.size}
            return [
                Note(key, **slope.factors(), p=slope.p_value)
                for key, slope in slopes.items()
                if slope is not None and slope.p_value < SIGNIFICANT
            ]
        notes = [
            Note(key, year=as_of, **slope.factors())
            for key, slope in (("as_of_rate", self.rate), ("as_of_size", self.size))
            if slope is not None
        ]
        if not self.first <= as_of <= self.last:
            notes.append(Note("as_of_beyond", year=as_of, first=self.first, last=self.last))
        return notes


def fit_trend(records: Iterable[VolumeRecord]) -> Trend:
    """The trends of all paths together, each path with a rate and a mean volume of its own.

    Rate: given how many records a path has, their years are draws from its observed years with
    weights exp(slope · year). Volumes: least squares of log volume on the year, within paths.
    Records of one winter go together: the variance of the first is that of the winters' sums, that
    of the second is by clusters.
    """
    known = [record for record in records if record.n_events]
    first = min((record.first_year for record in known), default=0)
    last = max((record.last_year for record in known), default=0)
    return Trend(_rate(known, first, last), _size(known), first, last)


def _rate(records: list[VolumeRecord], first: int, last: int) -> Slope | None:
    years = np.concatenate([np.empty(0, np.int64), *(r.event_years for r in records)])
    if not _enough(years):
        return None
    seen = [(r.observed_years(), r.n_events) for r in records]
    total, slope = float(np.sum(years)), 0.0
    for _ in range(50):
        mean, variance, expected = 0.0, 0.0, np.zeros(last - first + 1)
        for t, n_events in seen:
            weight = np.exp(slope * (t - t.mean()))
            weight *= n_events / weight.sum()
            middle = float(weight @ t) / n_events
            mean += n_events * middle
            variance += float(weight @ (t - middle) ** 2)
            expected[t - first] += weight
        step = float(np.clip((total - mean) / variance, -0.1, 0.1)) if variance else 0.0
        slope += step
        if abs(step) < 1e-9:
            break
    if variance == 0.0:
        return None
    there = expected > 0.0
    free = int(there.sum()) - 2
    counts = np.bincount(years - first, minlength=len(expected))[there]
    spread = float(np.sum((counts - expected[there]) ** 2 / expected[there])) / free
    return _slope(slope, np.sqrt(max(spread, 1.0) / variance), free)


def _size(records: list[VolumeRecord]) -> Slope | None:
    measured = [r for r in records if len(r.log_volumes) >= 2]
    years = np.concatenate([np.empty(0, np.int64), *(r.volume_years for r in measured)])
    if not _enough(years):
        return None
    t = np.concatenate([r.volume_years - r.volume_years.mean() for r in measured])
    v = np.concatenate([r.log_volumes - r.log_volumes.mean() for r in measured])
    square = float(t @ t)
    if square == 0.0 or len(t) < len(measured) + 3:
        return None
    slope = float(t @ v) / square
    winters, which = np.unique(years, return_inverse=True)
    error = v - slope * t
    scores = np.bincount(which, t * error)
    free = len(t) - len(measured) - 1
    # By clusters, and not less than if each record stood alone: few clusters spread too little.
    variance = max(float(scores @ scores) * len(t), float(error @ error) * square) / free
    return _slope(slope, np.sqrt(variance) / square, min(len(winters), free) - 1)


def _enough(years: Ints) -> bool:
    return len(years) >= FEWEST_RECORDS and len(np.unique(years)) >= LEAST_WINTERS


def _slope(per_year: float, se: float, free: int) -> Slope:
    p = 2.0 * float(stats.t.sf(abs(per_year) / se, free)) if se > 0.0 else 1.0
    return Slope(10.0 * per_year, 10.0 * float(se), p)


@dataclass(frozen=True, slots=True, eq=False)
class YearDraws:
    """Draws as of a year: `factor` `[n]` times the rate, log volumes larger by `shift` `[n]`."""

    base: FrequencyDraws
    factor: Floats
    shift: Floats

    @property
    def rate(self) -> Floats:
        """The rate of that year."""
        return self.base.rate * self.factor

    def rate_over(self, log_volume: Floats) -> Floats:
        """Each draw's rates, between nodes."""
        low, high = log_volume.min() - self.shift.max(), log_volume.max() - self.shift.min()
        nodes = np.linspace(low, high, NODES)
        rows = zip(self.base.rate_over(nodes), self.shift, strict=True)
        over = np.array([np.interp(log_volume - shift, nodes, row) for row, shift in rows])
        return np.asarray(over * self.factor[:, None])

    def log_volume(self, chance: float | Floats) -> Floats:
        """Where the rate, less the factor, is that of years with one or more."""
        of_base = -np.expm1(np.log1p(-chance) / self.factor)
        return np.asarray(self.base.log_volume(of_base) + self.shift)

    def ends(self) -> tuple[float, float]:
        """From the smallest to the largest of shifted draws."""
        low, high = self.base.ends()
        moved = np.quantile(self.shift, [0.1, 0.9])
        return low + float(moved[0]), high + float(moved[1])


def rate_factor(
    trend: Trend, record: VolumeRecord, year: int, n_draws: int, rng: np.random.Generator
) -> Floats:
    """Draws of a year's rate over the mean rate of the observed years of a path."""
    if trend.rate is None:
        return np.ones(n_draws)
    slope = rng.normal(trend.rate.mean, trend.rate.se, n_draws) / 10.0
    return np.asarray(1.0 / np.exp(slope[:, None] * (record.observed_years() - year)).mean(axis=1))


def as_of(
    draws: FrequencyDraws, trend: Trend, record: VolumeRecord, year: int, rng: np.random.Generator
) -> YearDraws:
    """The draws of a path as of a year, with the uncertainty of the trends."""
    n_draws = len(draws.rate)
    factor = rate_factor(trend, record, year, n_draws, rng)
    shift = np.zeros(n_draws)
    if trend.size is not None and len(record.volume_years):
        slope = rng.normal(trend.size.mean, trend.size.se, n_draws) / 10.0
        shift = slope * (year - record.volume_years.mean())
    return YearDraws(draws, factor, shift)
