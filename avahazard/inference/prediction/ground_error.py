"""What the error of a profile's points does to runouts: the same block on ground as it might be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import drawn_site
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import look_up

GROUND_DRAWS = 24


@dataclass(frozen=True, slots=True, eq=False)
class GroundError:
    """Standard deviations (m) over draws of the ground, each `[n_events]`.

    Of the stop's place `x`, of its `elevation`, and of what would be recorded, in the coordinate
    of each record. What left its profile counts as at its end; nought without a profile.
    """

    x: Floats
    elevation: Floats
    record: Floats


def ground_error(
    model: FittedModel,
    rng: np.random.Generator,
    friction: Floats | None = None,
    n_draws: int = GROUND_DRAWS,
) -> GroundError:
    """How far each event's stop moves as the ground varies within the error of its points.

    One draw of each path's ground (`physics.ground_spline`) is shared by the events on it. Every
    event keeps its `friction` `[n_events]`, by default the posterior median for its volume, and
    the effects their posterior mean. What all events of a path have in common of this error, a
    calibration on the same points has partly taken into its friction: the sum of squares over
    events is an upper bound of what the points' error adds to a model's misfit.
    """
    observations, posterior = model.observations, model.posterior
    if friction is None:
        friction = model.median_friction(np.exp(observations.volumes.mean))
    values = posterior.layout.effect_values(model.draws.mean(axis=0))
    stops = np.empty((3, n_draws, observations.n_events))
    for k in range(n_draws):
        sites = tuple(drawn_site(site, rng) for site in observations.sites)
        drawn = replace(observations, sites=sites)
        tables = predict_records(
            drawn, posterior.effects, values, float(posterior.specification.centrifugal)
        )
        record, x, elevation, _ = look_up(tables, friction[:, None])
        stops[:, k] = record[:, 0], x[:, 0], elevation[:, 0]
    record_sd, x_sd, elevation_sd = np.nan_to_num(stops).std(axis=1)
    return GroundError(x=x_sd, elevation=elevation_sd, record=record_sd)
