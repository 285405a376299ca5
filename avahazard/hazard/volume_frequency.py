"""How often which volumes come down a path, from its record and those of its region."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.event_volumes import EventVolumes, event_volumes
from avahazard.hazard.frequency_draws import FrequencyDraws, GevDraws, ThresholdDraws
from avahazard.hazard.shape_grid import (
    gev_draws,
    gev_likelihood,
    gpd_draws,
    gpd_likelihood,
    over_locations,
    regional_prior,
    shape_prior,
)
from avahazard.hazard.volume_record import VolumeRecord, without_record_error
from avahazard.records.errors import AvahazardError
from avahazard.results.volumes import ReturnLevel

Floats = NDArray[np.float64]
Family = Literal["gev", "gpd"]

ENOUGH_MAXIMA = 30
"""Maxima, or excesses over the threshold, from which a path stands alone."""
FEWEST_TELLING = 3
"""Maxima, or excesses, from which a path tells others of scale and shape."""
IMPOSSIBLE = -1e6
"""A log likelihood under this is one of nought: sums keep their digits."""
N_DRAWS = 400
USE_VOLUME = "Give the volume itself with --volume."


@dataclass(frozen=True, slots=True, eq=False)
class VolumeFrequency:
    """Posterior draws of one path's frequency, and in `method` where they come from.

    `pooled`: scale and shape lean on the other paths' records. `longest_years`: past twice as
    many, or past the ends of a table in `table_years`, a return period is an extrapolation.
    `source`: the records of events, a table of the user, or snowfall.
    """

    path_id: str
    draws: FrequencyDraws
    method: str
    pooled: bool
    record: VolumeRecord | None = None
    longest_years: float = np.inf
    table_years: tuple[float, float] | None = None
    source: Literal["records", "given", "snow"] = "records"

    def extrapolated(self, return_period_years: float) -> bool:
        """Whether the record or the table does not reach to this return period."""
        if self.table_years is not None:
            first, last = self.table_years
            return not first <= return_period_years <= last
        return return_period_years > 2 * self.longest_years

    def volumes(self) -> EventVolumes:
        """Rates and volumes of all avalanches, for the runout exceeded once in T years."""
        low, high = self.draws.ends()
        return event_volumes(self.draws.rate, self.draws.rate_over, low, high)


@dataclass(frozen=True, slots=True, eq=False)
class Together:
    """Sum of the log likelihoods of paths over the grid: of `n_paths` with `n_values` in all.

    `possible` sums those that are not nought, `n_impossible` counts the paths whose is, both
    `[n_scales, n_shapes]`: so one can be taken away again.
    """

    n_paths: int = 0
    n_values: int = 0
    possible: Floats | float = 0.0
    n_impossible: NDArray[np.int64] | int = 0

    def plus(self, likelihood: Floats, n_values: int, sign: int) -> Together:
        """With one path more (`sign` 1) or less (-1)."""
        impossible = likelihood < IMPOSSIBLE
        return Together(
            self.n_paths + sign,
            self.n_values + sign * n_values,
            self.possible + sign * np.where(impossible, 0.0, likelihood),
            self.n_impossible + sign * impossible,
        )

    @property
    def likelihood(self) -> Floats:
        """The sum, -inf where a path has nought."""
        return np.where(self.n_impossible == 0, self.possible, -np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Volume records of all paths, free of their errors, and what they say of scale and shape."""

    records: dict[str, VolumeRecord]
    family: Family
    threshold_m3: float | None
    kept: dict[str, Together] = field(default_factory=dict, init=False)

    def sample(self, path_id: str) -> Floats:
        """The yearly maxima of a path, or the excesses over its threshold, of log volume."""
        record = self.records[path_id]
        if self.family == "gev":
            return record.log_maxima
        over = record.log_volumes - self.threshold(path_id)
        return np.asarray(over[over > 0.0])

    def threshold(self, path_id: str) -> float:
        """The log volume that excesses are counted from: the path's median where none is given."""
        if self.threshold_m3 is not None:
            return float(np.log(self.threshold_m3))
        values = self.records[path_id].log_volumes
        return float(np.median(values)) if len(values) else 0.0

    def likelihood(self, path_id: str) -> Floats:
        """Log likelihood over the grid of `shape_grid`, as far as it is not nought."""
        sample = self.sample(path_id)
        if self.family == "gpd":
            return gpd_likelihood(sample)
        return gev_likelihood(sample, least=IMPOSSIBLE)

    def scale_and_shape(self, likelihood: Floats) -> Floats:
        """The same of scale and shape alone `[n_scales, n_shapes]`."""
        return over_locations(likelihood) if self.family == "gev" else likelihood

    def tells(self, path_id: str) -> bool:
        """Whether a path has enough to tell others of scale and shape."""
        return len(self.sample(path_id)) >= FEWEST_TELLING

    @property
    def together(self) -> Together:
        """What all paths that tell say together; kept."""
        if "" not in self.kept:
            telling = [path_id for path_id in self.records if self.tells(path_id)]
            total = Together()
            for path_id in telling:
                own = self.scale_and_shape(self.likelihood(path_id))
                total = total.plus(own, len(self.sample(path_id)), 1)
            self.kept[""] = total
        return self.kept[""]

    def others(self, path_id: str, likelihood: Floats) -> Together:
        """The same without a path, whose `likelihood` is given."""
        if not self.tells(path_id):
            return self.together
        return self.together.plus(self.scale_and_shape(likelihood), len(self.sample(path_id)), -1)


def region_of(
    records: Sequence[VolumeRecord], family: Family = "gev", threshold_m3: float | None = None
) -> Region:
    """Make the records ready for `fit_volume_frequency`; they are freed of their errors here.

    Raises `AvahazardError` for a threshold that is not over 0, or without the family gpd.
    """
    if threshold_m3 is not None and not (np.isfinite(threshold_m3) and threshold_m3 > 0.0):
        raise AvahazardError(f"The threshold is {threshold_m3:g}.", "Give a volume over 0, in m3.")
    if threshold_m3 is not None and family == "gev":
        raise AvahazardError(
            "A threshold has no use for a GEV of yearly maxima.", "Add --frequency gpd."
        )
    return Region({r.path_id: r for r in without_record_error(records)}, family, threshold_m3)


def fit_volume_frequency(
    region: Region, path_id: str, rng: np.random.Generator, n_draws: int = N_DRAWS
) -> VolumeFrequency:
    """Posterior of the frequency of volumes of one path in its region.

    On their own scale volumes span decades and a GEV or Pareto of them has neither mean nor
    variance; their logs are near Gumbel or exponential, and are what is fitted. The prior is flat
    in location and log scale and weak on the shape. A path with under 30 maxima (or excesses)
    takes as prior of scale and shape the likelihood of the other paths' records, widened by how
    far paths differ (`regional_prior`). Raises `AvahazardError` where the path has no volume,
    where it has none over the threshold, or where no path of the region has 3.
    """
    record = region.records[path_id]
    if not len(record.log_volumes):
        raise AvahazardError(f"No dated event of path {path_id} has a volume.", USE_VOLUME)
    own = region.sample(path_id)
    what = "yearly maxima" if region.family == "gev" else "volumes over the threshold"
    if not len(own):
        raise AvahazardError(
            f"Path {path_id} has no volume over the threshold.", "Give a smaller --threshold."
        )
    likelihood = region.likelihood(path_id)
    others = region.others(path_id, likelihood) if len(own) < ENOUGH_MAXIMA else Together()
    pooled = others.n_paths > 0
    if len(own) < FEWEST_TELLING and not pooled:
        raise AvahazardError(
            f"Too few {what} for a return period: path {path_id} has {len(own)}, "
            "and no path has 3.",
            USE_VOLUME,
        )
    if len(own) > 1 and np.ptp(own) == 0.0 and not pooled:
        raise AvahazardError(f"All {what} of path {path_id} are equal.", USE_VOLUME)
    prior = shape_prior()
    if pooled:
        prior = regional_prior(others.likelihood)
    draws: FrequencyDraws
    if region.family == "gev":
        gev = gev_draws(own, prior, likelihood, n_draws, rng)
        empty = record.n_years - record.n_event_years
        draws = GevDraws(rng.beta(record.n_event_years + 0.5, empty + 0.5, n_draws), gev)
    else:
        scale, shape = gpd_draws(prior, likelihood, n_draws, rng)
        draws = _threshold_draws(record, region.threshold(path_id), scale, shape, rng)
    return VolumeFrequency(
        path_id=path_id,
        draws=draws,
        method=_words(region, record, own, others),
        pooled=pooled,
        record=record,
        longest_years=record.n_years,
    )


def _threshold_draws(
    record: VolumeRecord, threshold: float, scale: Floats, shape: Floats, rng: np.random.Generator
) -> ThresholdDraws:
    """Rates with a Jeffreys prior of the Poisson, shares with one of the binomial."""
    n = len(scale)
    below = np.sort(record.log_volumes[record.log_volumes <= threshold])
    n_over = len(record.log_volumes) - len(below)
    weight = rng.dirichlet(np.ones(len(below)), n) if len(below) else np.zeros((n, 0))
    share = rng.beta(n_over + 0.5, len(below) + 0.5, n) if len(below) else np.ones(n)
    rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, n)
    return ThresholdDraws(rate, share, threshold, scale, shape, below, weight)


def return_volume(frequency: VolumeFrequency, return_period_years: float) -> ReturnLevel:
    """The volume that a year's largest avalanche exceeds with chance 1/T.

    Raises `AvahazardError` where events are rarer than T.
    """
    period = return_period_years
    observed = frequency.record if frequency.source == "records" else None
    if observed is not None and observed.event_year_chance * period <= 1:
        raise AvahazardError(
            f"Path {observed.path_id} has an event in {observed.n_event_years} of "
            f"{observed.n_years} years: no volume returns every {period:g} years.",
            f"Ask for a return period over {1 / observed.event_year_chance:.0f} years.",
        )
    low, middle, high = np.exp(
        np.quantile(frequency.draws.log_volume(1.0 / period), [0.05, 0.5, 0.95])
    )
    return ReturnLevel(
        return_period_years=period,
        volume_m3=float(middle),
        q05_m3=float(low),
        q95_m3=float(high),
        extrapolated=frequency.extrapolated(period),
    )


def _words(region: Region, record: VolumeRecord, own: Floats, others: Together) -> str:
    """How the volume of a return period is found, in one sentence."""
    if region.family == "gev":
        text = f"GEV of log annual maxima, {len(own)} maxima"
    else:
        threshold = float(f"{np.exp(region.threshold(record.path_id)):.3g}")
        given = "given" if region.threshold_m3 is not None else "the median"
        text = (
            f"generalised Pareto of log volume over {threshold:.0f} m3 ({given}), "
            f"{len(own)} excesses"
        )
    text += ", posterior"
    if others.n_paths:
        text += (
            f"; scale and shape with a prior from {others.n_paths} other paths ({others.n_values})"
        )
    text += (
        f"; {record.n_events} records over {record.window} "
        f"({record.first_year} to {record.last_year}"
        f"{f', {record.n_unobserved} years not observed' if record.n_unobserved else ''}): "
        f"{record.events_per_year:.3g} a year"
    )
    if record.n_left_out:
        text += f"; {record.n_left_out} undated or outside these years left out"
    return text
