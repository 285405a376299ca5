"""How far these data tell effects apart, and how large one would have been detected."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import stats

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import LEFT

TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""


def explained(fit: Refit, base: Refit) -> Floats:
    """What an effect changes.

    Log friction that each record asks for less what the law gives, the base model's minus the
    fit's, `[n_events]`.
    """
    return _residual(base) - _residual(fit)


def _residual(fit: Refit) -> Floats:
    posterior = fit.posterior
    nodes = posterior.nodes.at(fit.mode.u)
    asked = np.log(np.maximum(likely_friction(nodes, posterior.layout.log_scatter), 1e-3))
    given, _ = posterior.location_and_scatter(fit.mode.u)
    mean = np.sum(given * posterior.weight(fit.mode.u), axis=1)
    if not posterior.layout.log_scatter:
        mean = np.log(np.maximum(mean, 1e-3))
    # An event that left asks for no certain friction.
    return np.asarray(np.nan_to_num(asked - mean))


def correlation(first: Floats, second: Floats, posterior: Posterior) -> float:
    """Correlation of two changes once law and paths have taken their part (least squares)."""
    volume = np.exp(posterior.observations.volumes.mean)
    groups = posterior.observations.columns.path_index
    nuisance = np.column_stack(
        [np.ones(len(volume)), volume / np.mean(volume), np.log(volume)]
        + [groups == k for k in np.unique(groups)[1:]]
    ).astype(float)

    def rest(values: Floats) -> Floats:
        return np.asarray(values - nuisance @ np.linalg.lstsq(nuisance, values, rcond=None)[0])

    a, b = rest(first), rest(second)
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 1e-12 else 0.0


class FrictionVariance(NamedTuple):
    """Variance of log friction of each event `[n_events]`.

    By its scatter, and by its record's error (0 for events that left their profile, of which no one
    friction is known).
    """

    scatter: Floats
    record: Floats

    @property
    def total(self) -> Floats:
        """Both together."""
        return np.asarray(self.scatter + self.record)


def friction_variance(fit: Refit) -> FrictionVariance:
    """The two parts at the mode of a fit; normal scatter is taken relative to its middle."""
    posterior = fit.posterior
    location, scatter = posterior.location_and_scatter(fit.mode.u)
    nodes = posterior.nodes.at(fit.mode.u)
    place = nodes.place
    if not posterior.layout.log_scatter:
        scatter = scatter / np.maximum(location, 1e-3)
        place = np.log(np.maximum(place, 1e-3))
    mean = np.sum(place * nodes.weight, axis=1, keepdims=True)
    record = np.sum(nodes.weight * (place - mean) ** 2, axis=1)
    return FrictionVariance(
        scatter=np.mean(scatter**2, axis=1),
        record=np.where(nodes.is_probability, 0.0, np.maximum(record, 0.0)),
    )


class Detectable(NamedTuple):
    """The smallest effect that would have been seen with 80 % power.

    As rms of log friction, in metres (H/L where that is recorded), and as the share that it would
    be of all that scatters log friction, errors of the records included: over 1 where even more
    than that could be missed.
    """

    log_friction: float
    metres: float
    share: float


def detectable(base: Refit, critical_gain: float) -> Detectable:
    """The smallest effect that would have been seen with 80 % power.

    A shift of rms δ in log friction has, on n events of total variance s², a gain with
    non-centrality n δ²/s²; the gain must pass `critical_gain`, and be worth `MARGIN` after the
    price of one more parameter.
    """
    observations = base.posterior.observations
    stopped = observations.kind != LEFT
    variance = friction_variance(base)
    information = float(np.sum(1.0 / variance.total[stopped]))
    price = 0.5 * float(np.log1p(information * TYPICAL_SD**2))
    gain = max(critical_gain, MARGIN + price)
    shift = (np.sqrt(2.0 * gain) + float(stats.norm.ppf(0.8))) / np.sqrt(information)
    # The record's spread in metres against that in log friction tells metres per unit.
    sigma = observations.recorded_sigma(base.posterior.record_sigma(base.mode.u))
    ratio = sigma[stopped] / np.sqrt(np.maximum(variance.record[stopped], 1e-8))
    return Detectable(
        log_friction=float(shift),
        metres=float(shift * np.median(ratio)),
        share=float(shift**2 * information / np.count_nonzero(stopped)),
    )
