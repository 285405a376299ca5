"""What the error of a profile's points does to runouts, through the friction that they let show."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.observations import ELEVATION, Observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import look_up

MOST_OFF = 0.9
"""Share of the friction: errors as large as the fall itself say no more than that."""


def ground_error(model: FittedModel, friction: Floats | None = None) -> Floats:
    """Standard deviation `[n_events]` (m, in each record's coordinate) of the predicted stop.

    Along the path a block spends μ g dx and gains g dy, so what counts is how far the heights of
    its release and of its stop are off, s₀ and s₁: it stops where one with a friction off by
    √(s₀² + s₁²) / L does, L its reach (Ancey 2005, § 2: μ = H / L without curvature). An
    elevation is off by s₁ besides, as the stop lies on other ground. Every event keeps its
    `friction` `[n_events]`, by default the posterior median for its volume. What left its profile
    counts as at its end. Nought without a profile, or where the ground is a polynomial of points
    without error.
    """
    observations, posterior = model.observations, model.posterior
    if friction is None:
        friction = model.median_friction(np.exp(observations.volumes.mean))
    tables = posterior.nodes.predicted_at(model.draws.mean(axis=0))
    stop = look_up(tables, friction[:, None])[1][:, 0]
    released, start, end = _errors(observations, stop)
    reach = np.maximum(stop - released, 1.0)
    off = np.where(start + end > 0.0, np.hypot(start, end) / reach, 0.0)
    off = np.minimum(off, MOST_OFF * friction)
    around = look_up(tables, friction[:, None] + off[:, None] * np.array([-1.0, 1.0]))[0]
    moved = 0.5 * np.abs(around[:, 1] - around[:, 0])
    # By a metre of height at either end, and the stop's own height on top.
    steep = np.divide(moved, np.hypot(start, end), out=np.zeros_like(moved), where=off > 0.0)
    own = end * (observations.kind == ELEVATION)
    return np.asarray(np.hypot(steep * start, steep * end + own))


def _errors(observations: Observations, stop: Floats) -> tuple[Floats, Floats, Floats]:
    """x of each release (m) `[n_events]`, and the ground's error (m) there and at each `stop`."""
    n = observations.n_events
    released, start, end = np.zeros(n), np.zeros(n), np.zeros(n)
    for k, site in enumerate(observations.sites):
        mine = np.flatnonzero(observations.columns.path_index == k)
        released[mine] = site.release_x[observations.release[mine]]
        if site.smooth.posterior is None or not len(mine):
            continue
        places = np.concatenate([released[mine], stop[mine]])
        start[mine], end[mine] = np.split(site.smooth.posterior.sd(places), 2)
    return released, start, end
