"""How closely one event tells log friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.refits import Refit


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
