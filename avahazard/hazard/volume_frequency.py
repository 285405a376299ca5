"""How often which volumes come down a path, from its record and those of its region."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.event_volumes import EventVolumes, event_volumes
from avahazard.hazard.frequency_draws import FrequencyDraws, GevDraws, ThresholdDraws
from avahazard.hazard.shape_grid import gev_draws, gpd_draws, regional_prior, shape_prior
from avahazard.hazard.volume_record import VolumeRecord
from avahazard.hazard.volume_region import FEWEST_TELLING, Region, Together
from avahazard.message import counted
from avahazard.records.errors import AvahazardError
from avahazard.results.volumes import ReturnLevel

ENOUGH_MAXIMA = 30
"""Maxima, or excesses over the threshold, from which a path stands alone."""
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
        found = event_volumes(self.draws.rate, self.draws.rate_over, low, high)
        return replace(found, seen_only=self.source == "records")


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
    error = region.error(path_id)
    prior = shape_prior(error=error)
    if pooled:
        prior = regional_prior(others.likelihood, region.error())
    draws: FrequencyDraws
    if region.family == "gev":
        middle = float(region.recorded[path_id].log_volumes.mean())
        gev = gev_draws(own, prior, likelihood, n_draws, rng, error=error, middle=middle)
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
            f"; scale and shape with a prior from {counted(others.n_paths, 'other path')} "
            f"({counted(others.n_values, 'volume')})"
        )
    n = record.n_unobserved
    unobserved = f", {counted(n, 'year')} not observed" if n else ""
    text += (
        f"; {counted(record.n_events, 'record')} over {record.window} "
        f"({record.first_year} to {record.last_year}"
        f"{unobserved}): "
        f"{record.events_per_year:.3g} a year"
    )
    if record.n_left_out:
        text += f"; {record.n_left_out} undated or outside these years left out"
    return text
