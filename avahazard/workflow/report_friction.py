"""Friction against volume for the report: the law and the scatter about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.seeds import generator
from avahazard.report.html.content import FrictionView
from avahazard.workflow.stored_model import StoredFit, coordinates_for

Floats = NDArray[np.float64]

N_VOLUMES = 60
N_PARAMETERS = 1000
DRAWS_EACH = 8
ROOM = 1.5
"""The curve goes on beyond the smallest and largest volume by this factor."""
STUDENT_DF = 4


def friction_view(stored: StoredFit, posterior: Posterior) -> FrictionView | None:
    """The calibrated friction over the recorded volumes; None where none is recorded.

    Effects on friction by columns of the event are at their reference; the spread between paths
    is left out.
    """
    recorded = posterior.observations.columns.log_volume
    recorded = recorded[np.isfinite(recorded)]
    if not len(recorded):
        return None
    volume = np.geomspace(np.exp(recorded.min()) / ROOM, np.exp(recorded.max()) * ROOM, N_VOLUMES)
    u = coordinates_for(stored, posterior)
    u = u[np.linspace(0, len(u) - 1, min(len(u), N_PARAMETERS)).round().astype(int)]
    law = posterior.layout.law
    middle = law.log_friction(u[:, : len(law.coordinates)], volume)
    return FrictionView(
        volume=volume,
        law=np.exp(np.quantile(middle, [0.05, 0.5, 0.95], axis=0)),
        scatter=None
        if stored.method == "metropolis"
        else np.quantile(
            _frictions(stored, posterior, u, middle, volume), [0.05, 0.25, 0.75, 0.95], axis=0
        ),
    )


def _frictions(
    stored: StoredFit, posterior: Posterior, u: Floats, middle: Floats, volume: Floats
) -> Floats:
    """Draws of friction `[n_draws, n_volumes]` about log median friction `middle`."""
    layout = posterior.layout
    log_scatter = np.repeat(u[:, layout.scatter, None], len(volume), axis=1)
    if layout.scatter_slope is not None:
        log_scatter -= u[:, layout.scatter_slope, None] * volume / layout.reference_volume
    rng = generator(0, "report", "friction")
    shape = (DRAWS_EACH, *middle.shape)
    if stored.specification.tails == "student":
        noise = rng.standard_t(STUDENT_DF, size=shape)
    else:
        noise = rng.standard_normal(shape)
    scatter = np.exp(log_scatter) * noise
    if stored.specification.distribution == "lognormal":
        drawn = np.exp(middle + scatter)
    else:
        drawn = np.exp(middle) + scatter
    return np.asarray(drawn.reshape(-1, len(volume)))
