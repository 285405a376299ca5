"""Friction against volume for the report: the law and the scatter about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_scatter import draws, friction
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.report.html.content import FrictionView

Floats = NDArray[np.float64]

N_VOLUMES = 60
N_PARAMETERS = 1000
DRAWS_EACH = 8
ROOM = 1.5
"""The curve goes on beyond the smallest and largest volume by this factor."""


def friction_view(model: FittedModel) -> FrictionView | None:
    """The calibrated friction over the recorded volumes; None where none is recorded.

    Effects on friction by columns of the event are at their reference; the spread between paths
    is left out.
    """
    posterior = model.posterior
    recorded = posterior.observations.columns.log_volume
    recorded = recorded[np.isfinite(recorded)]
    if not len(recorded):
        return None
    volume = np.geomspace(np.exp(recorded.min()) / ROOM, np.exp(recorded.max()) * ROOM, N_VOLUMES)
    u = model.draws[model.evenly(min(len(model.draws), N_PARAMETERS))]
    law = posterior.layout.law
    middle = law.log_friction(u[:, : len(law.coordinates)], volume)
    return FrictionView(
        volume=volume,
        law=np.exp(np.quantile(middle, [0.05, 0.5, 0.95], axis=0)),
        scatter=None
        if model.sigma_m is not None
        else np.quantile(
            _frictions(posterior, u, middle, volume), [0.05, 0.25, 0.75, 0.95], axis=0
        ),
    )


def _frictions(posterior: Posterior, u: Floats, middle: Floats, volume: Floats) -> Floats:
    """Draws of friction `[n_draws, n_volumes]` about log median friction `middle`."""
    layout = posterior.layout
    log_scatter = np.repeat(u[:, layout.scatter, None], len(volume), axis=1)
    if layout.scatter_slope is not None:
        log_scatter -= u[:, layout.scatter_slope, None] * volume / layout.reference_volume
    rng = generator(0, "report", "friction")
    shape = (DRAWS_EACH, *middle.shape)
    scatter = np.exp(log_scatter) * draws(rng, shape, posterior.specification.tails == "student")
    in_log = layout.log_scatter
    drawn = friction(middle if in_log else np.exp(middle), scatter, in_log)
    return np.asarray(drawn.reshape(-1, len(volume)))
