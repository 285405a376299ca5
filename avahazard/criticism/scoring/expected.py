"""The records to be expected: stops drawn from the model, with the error of the record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats
from avahazard.effects.effect import LimitEffect, RecordErrorEffect, of_kind
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import raised_by
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE, Observations
from avahazard.inference.prediction import predict_stops

SPARE = 4
"""Draws for each one that is needed, where some would not be seen."""
FEWEST_SEEN = 20


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedRecords:
    """Records `observed` `[n_events]` (m) and `draws` `[n_events, n_draws]` of what they might be.

    Both are in the coordinate of each record (elevation, x, runout length, H/L); `sigma`
    `[n_events]` is its measurement error. What left its profile, in the records or in the draws
    (`left` `[n_events, n_draws]`), counts as reaching the profile's end. `x` `[n_events, n_draws]`
    is the place of the stops, nan without a profile. `sign` `[n_events]` is -1 where an x or a
    length stands among elevations, so that errors of either point the same way.
    """

    observed: Floats
    sigma: Floats
    draws: Floats
    left: Bools
    x: Floats
    sign: Floats

    @property
    def error(self) -> Floats:
        """Predicted mean less record `[n_events]` (m), the other way round where `sign` is -1."""
        return np.asarray(self.sign * (self.draws.mean(axis=1) - self.observed))


def expected_records(model: FittedModel, n_draws: int, rng: np.random.Generator) -> ExpectedRecords:
    """Draw records of every event of the model.

    On paths where stops above an elevation are not seen, only draws that would be
    seen are kept.
    """
    observations, posterior = model.observations, model.posterior
    limited = bool(np.any(np.isfinite(_limits(posterior, model.draws[:1]))))
    n_stops = SPARE * n_draws if limited else n_draws
    stops = predict_stops(model, n_stops, rng, release_off=True)
    end = profile_end(observations)[:, None]
    noise = rng.standard_normal(stops.record.shape)
    noise *= observations.recorded_sigma(stops.sigma.T).T
    draws = observations.as_recorded(stops.record) + noise
    np.copyto(draws, end, where=stops.left)
    left, x = stops.left, stops.x
    if limited:
        first, place = np.unique(model.evenly(n_stops), return_inverse=True)
        limit = _limits(posterior, model.draws[first])[:, place]
        # A declared limit is of places, an estimated one of records.
        declared = np.isfinite(observations.limit)[:, None]
        values = posterior.layout.effect_values(np.median(model.draws, axis=0))
        raised = raised_by(observations, posterior.effects, values)[:, None]
        height = stops.elevation + np.where(declared, -raised, noise)
        excess = np.where(stops.left, -np.inf, height - limit)
        kept = _seen_first(np.nan_to_num(excess, nan=-np.inf, neginf=-np.inf), n_draws, rng)
        rows = np.arange(observations.n_events)[:, None]
        # A draw that came nearest without being seen stands for one that just was.
        short = np.maximum(excess[rows, kept], 0.0)
        in_elevation = (observations.kind == ELEVATION)[:, None] & np.isfinite(short)
        draws, left, x = draws[rows, kept], left[rows, kept], x[rows, kept]
        draws = np.where(in_elevation, draws - short, draws)
    return ExpectedRecords(
        observed=observed_records(observations),
        sigma=mean_record_sigma(model),
        draws=draws,
        left=left,
        x=x,
        sign=error_sign(observations),
    )


def mean_record_sigma(model: FittedModel) -> Floats:
    """Error of the records `[n_events]` (m): root of its mean square over the posterior."""
    posterior, observations = model.posterior, model.observations
    if not of_kind(posterior.effects, RecordErrorEffect):
        return observations.recorded_sigma(observations.sigma)
    squares = [posterior.record_sigma(u) ** 2 for u in model.draws]
    return observations.recorded_sigma(np.sqrt(np.mean(squares, axis=0)))


def observed_records(observations: Observations) -> Floats:
    """The records `[n_events]` (m); an event that left its profile reached its end."""
    observed = observations.as_recorded(observations.observed)
    return np.where(observations.kind == LEFT, profile_end(observations), observed)


def error_sign(observations: Observations) -> Floats:
    """-1 for an x or a length where elevations were recorded too, else 1, `[n_events]`."""
    farther_is_more = (observations.kind == PLACE) | (observations.kind == LENGTH)
    if np.all(farther_is_more | (observations.kind == LEFT)):
        return np.ones(observations.n_events)
    return np.where(farther_is_more, -1.0, 1.0)


def profile_end(observations: Observations) -> Floats:
    """The profile's end in the coordinate of each record, `[n_events]`; nan without a profile."""
    end = np.full(observations.n_events, np.nan)
    for k, site in enumerate(observations.sites):
        mine = observations.columns.path_index == k
        end[mine] = np.where(observations.kind[mine] == PLACE, site.smooth.x_max, site.end_y)
    return end


def _limits(posterior: Posterior, coordinates: Floats) -> Floats:
    """Elevation above which a stop is not seen, `[n_events, n_posterior]`; nan where all are."""
    observations = posterior.observations
    effects = of_kind(posterior.effects, LimitEffect)
    if not effects:
        return np.repeat(observations.limit[:, None], len(coordinates), axis=1)
    effect = effects[-1]
    each = [posterior.layout.effect_values(u)[effect.key] for u in coordinates]
    return np.column_stack([effect.limit(observations.columns, values) for values in each])


def _seen_first(excess: Floats, n_draws: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Index `[n_events, n_draws]` of draws that are seen; where too few are, some come twice.

    `excess` `[n_events, n_stops]` is by how much (m) each draw stops above the limit of sight.
    Where hardly any is seen, those that come nearest count too.
    """
    chosen = np.empty((len(excess), n_draws), dtype=np.int64)
    for i, row in enumerate(excess):
        found = np.flatnonzero(row <= 0.0)
        if len(found) < FEWEST_SEEN:
            found = np.sort(np.argsort(row, kind="stable")[:FEWEST_SEEN])
        # Evenly over the posterior, which the draws run through in order.
        chosen[i] = (
            found[np.linspace(0, len(found) - 1, n_draws).round().astype(np.int64)]
            if len(found) >= n_draws
            else rng.choice(found, n_draws)
        )
    return chosen
