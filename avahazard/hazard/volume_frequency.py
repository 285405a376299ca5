"""The volume of a return period, from the annual maxima of a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.gev import Gev, gev_from_l_moments, l_moments
from avahazard.hazard.volume_record import VolumeRecord
from avahazard.records.errors import AvahazardError

Floats = NDArray[np.float64]

ENOUGH_MAXIMA = 15
"""Annual maxima from which a path, or all paths together, can carry a shape of their own."""

N_BOOTSTRAP = 2000

USE_VOLUME = "Give the volume itself with --volume."


@dataclass(frozen=True, slots=True, eq=False)
class VolumeFrequency:
    """The fit for one path: `gev` is that of the log of a year's largest volume, given an event.

    `pool` holds the numbers of maxima of the paths that gave scale and shape, the path's own alone
    unless it has too few; `gumbel` tells that even together they were too few for a shape.
    """

    record: VolumeRecord
    gev: Gev
    pool: tuple[int, ...]
    pooled: bool
    gumbel: bool

    @property
    def method(self) -> str:
        """How the volume of a return period is found, in one sentence."""
        record = self.record
        text = (
            f"GEV{' (shape 0)' if self.gumbel else ''} of log annual maxima by L-moments, "
            f"{len(record.log_maxima)} maxima"
        )
        if self.pooled:
            text += (
                f", scale and shape pooled over {len(self.pool)} paths ({sum(self.pool)} maxima)"
            )
        text += (
            f"; {record.n_events} records over {record.window} "
            f"({record.first_year} to {record.last_year}): {record.events_per_year:.3g} a year"
        )
        if record.n_left_out:
            text += f"; {record.n_left_out} undated or outside these years left out"
        return text


@dataclass(frozen=True, slots=True)
class ReturnVolume:
    """Volume (m3) of a return period, with a 90 % interval of its estimate.

    `extrapolated`: the return period is over twice the observed years.
    """

    return_period_years: float
    volume_m3: float
    q05_m3: float
    q95_m3: float
    extrapolated: bool


def fit_volume_frequency(path_id: str, records: Sequence[VolumeRecord]) -> VolumeFrequency:
    """Fit the annual maxima of one of the paths in `records`.

    Volumes of a path span two to three decades, so on their own scale the GEV has shapes without
    mean or variance, where no estimator is good; their logs are near Gumbel. A path with under 15
    maxima keeps its own geometric mean and takes scale and shape from all paths: sample L-moments
    of the logs about each path's mean, averaged with weights n (regional frequency analysis,
    Hosking & Wallis 1997; means of logs, since scaling by medians of few would narrow the spread).
    With under 15 in all, the shape is 0. Raises `AvahazardError` with under 3 maxima in all or
    none on the path.
    """
    (record,) = (r for r in records if r.path_id == path_id)
    own = record.log_maxima
    if not len(own):
        raise AvahazardError(f"No dated event of path {path_id} has a volume.", USE_VOLUME)
    pooled = len(own) < ENOUGH_MAXIMA
    samples = [r.log_maxima for r in records] if pooled else [own]
    samples = [sample for sample in samples if len(sample) >= 3]
    pool = tuple(len(sample) for sample in samples)
    if not pool:
        raise AvahazardError(
            f"Too few yearly maxima for a return period: path {path_id} has {len(own)}, "
            "and no path has 3.",
            USE_VOLUME,
        )
    if all(np.ptp(sample) == 0 for sample in samples):
        raise AvahazardError(f"All yearly maxima of path {path_id} are equal.", USE_VOLUME)
    gumbel = sum(pool) < ENOUGH_MAXIMA
    gev = _fit(own, samples, gumbel)
    return VolumeFrequency(record, gev, pool, pooled, gumbel)


def return_volume(
    frequency: VolumeFrequency, return_period_years: float, rng: np.random.Generator
) -> ReturnVolume:
    """The volume exceeded by a year's largest avalanche once in T years on average.

    With p the chance that a year has an event and G the distribution of the maximum of such a
    year, p (1 - G(V_T)) = 1/T. The interval is a parametric bootstrap of maxima and event years,
    studentised: on log volume, the error over hypot(scale, distance of the quantile from the
    location) hardly depends on the parameters, so its distribution at the estimate serves.
    Raises `AvahazardError` where events are rarer than T.
    """
    record, gev, period = frequency.record, frequency.gev, return_period_years
    chance = record.event_year_chance
    if chance * period <= 1:
        raise AvahazardError(
            f"Path {record.path_id} has an event in {record.n_event_years} of {record.n_years} "
            f"years: no volume returns every {period:g} years.",
            f"Ask for a return period over {1 / chance:.0f} years.",
        )
    log_volume = float(gev.quantile(1 - 1 / (chance * period)))
    fits = _bootstrap(frequency, rng)
    chances = rng.binomial(record.n_years, chance, N_BOOTSTRAP) / record.n_years
    # where a bootstrap world has events rarer than T, the quantile is kept finite
    exceeded = np.minimum(1 / np.maximum(chances * period, 1e-9), 0.999)
    again = fits.quantile(1 - exceeded)
    error = (again - log_volume) / np.hypot(fits.scale, again - fits.location)
    low, high = np.quantile(error, [0.05, 0.95])
    spread = float(np.hypot(gev.scale, log_volume - gev.location))
    return ReturnVolume(
        return_period_years=period,
        volume_m3=float(np.exp(log_volume)),
        q05_m3=float(np.exp(log_volume - high * spread)),
        q95_m3=float(np.exp(log_volume - low * spread)),
        extrapolated=period > 2 * record.n_years,
    )


def _fit(own: Floats, samples: Sequence[Floats], gumbel: bool) -> Gev:
    """GEV with the mean of `own` `[..., n_own]`, scale and shape of all `samples` `[..., n]`."""
    weights = [sample.shape[-1] for sample in samples]
    moments = [l_moments(sample) for sample in samples]
    second = np.average(np.array([m[1] for m in moments]), axis=0, weights=weights)
    third = np.average(np.array([m[2] for m in moments]), axis=0, weights=weights)
    return gev_from_l_moments(own.mean(axis=-1), second, third, gumbel)


def _bootstrap(frequency: VolumeFrequency, rng: np.random.Generator) -> Gev:
    """Fits `[N_BOOTSTRAP]` of worlds drawn from the fit, in which every path has the fitted GEV."""
    own = frequency.gev.sample((N_BOOTSTRAP, len(frequency.record.log_maxima)), rng)
    if not frequency.pooled:
        return _fit(own, [own], frequency.gumbel)
    samples = [frequency.gev.sample((N_BOOTSTRAP, n), rng) for n in frequency.pool]
    return _fit(own, samples, frequency.gumbel)
