"""Friction under a model: the law, the scatter about it, and the events beside them."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.friction_model import FrictionModel
from avahazard.inference.paper.apparent import BackCalculation, back_calculate
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.report.html.content import FrictionView

N_VOLUMES = 60
N_PARAMETERS = 1000
DRAWS_EACH = 8
ROOM = 1.5
"""The curve goes on beyond the smallest and largest volume by this factor."""


def friction_view(model: FittedModel) -> FrictionView | None:
    """The calibrated friction over the recorded volumes; None where none is recorded.

    Effects on friction are at their reference, and the spread between paths is left out, as they
    are from `EventView.mu_reference`.
    """
    recorded = model.columns.log_volume
    recorded = recorded[np.isfinite(recorded)]
    if not len(recorded):
        return None
    volume = np.geomspace(np.exp(recorded.min()) / ROOM, np.exp(recorded.max()) * ROOM, N_VOLUMES)
    u = model.draws[model.evenly(min(len(model.draws), N_PARAMETERS))]
    law = model.layout.law
    middle = law.log_friction(u[:, : len(law.coordinates)], volume)
    return FrictionView(
        volume=volume,
        law=np.exp(np.quantile(middle, [0.05, 0.5, 0.95], axis=0)),
        scatter=None
        if model.sigma_m is not None
        else np.quantile(_frictions(model.friction, u, volume), [0.05, 0.25, 0.75, 0.95], axis=0),
    )


def apparent_friction(model: FittedModel) -> tuple[BackCalculation, Predicted]:
    """Friction that stops each event's block at its record, with the model's effects at work.

    Effects on the motion and on the record stand at the median of the posterior: so the
    frictions are those that the model's law is a law of. Also what was turned round for it.
    """
    observations = model.observations
    values = model.layout.effect_values(np.median(model.draws, axis=0))
    curvature = float(model.specification.centrifugal)
    predicted = predict_records(observations, model.effects, values, curvature)
    return back_calculate(observations, predicted), predicted


def from_reference(model: FittedModel) -> Floats:
    """What effects on friction and the path add to log friction `[n_events]`, at the median.

    Less of them, a friction may stand beside the law alone. nan for an event without a volume.
    """
    friction, columns = model.friction, model.columns
    u = np.median(model.draws, axis=0)
    volume = np.exp(columns.log_volume)
    known = np.where(np.isfinite(volume), volume, 1e4)
    events = friction.of_events(columns)
    location, _ = friction.location_and_scatter(u, known[:, None], events)
    law = model.layout.law
    at = location[:, 0] if model.layout.log_scatter else np.log(location[:, 0])
    added = at - law.log_friction(u[: len(law.coordinates)], known)
    by_path = [
        float(np.median(model.offsets[p])) if p in model.offsets else 0.0 for p in columns.paths
    ]
    offsets = np.array([*by_path, 0.0])[columns.path_index]
    return np.where(np.isfinite(volume), added + offsets, np.nan)


def _frictions(friction: FrictionModel, u: Floats, volume: Floats) -> Floats:
    """Draws of friction `[n_draws, n_volumes]` about the law alone."""
    location, scatter = friction.location_and_scatter(u, volume[None])
    shape = (DRAWS_EACH, len(u), len(volume))
    location, scatter = (np.broadcast_to(v[:, 0], shape) for v in (location, scatter))
    rng = generator(0, "report", "friction")
    return friction.draw(location, scatter, rng).reshape(-1, len(volume))
