"""Stops where no block can stop: on ground steeper than the friction that brings it there."""

from __future__ import annotations

import numpy as np

from avahazard.criticism.diagnosis.refits import Refit
from avahazard.inference.model.observations import ELEVATION, PLACE

FAR = 2.5
"""Errors of the record off the nearest stop, from which on it cannot be meant."""


def impossible_stops(base: Refit) -> tuple[str, ...]:
    """Events recorded within a jump of F(μ), further than `FAR` errors from both of its ends.

    A block stops where it slows down at rest, that is where tan θ < μ; on steeper ground it is
    caught or passes, whatever its friction. Such a record tells of something that a block lacks.
    """
    posterior = base.posterior
    observations = posterior.observations
    table = posterior.nodes.predicted_at(base.mode.u)
    found = []
    for i in np.flatnonzero(np.isin(observations.kind, (ELEVATION, PLACE))):
        record, reach = table.record[i], FAR * table.sigma[i]
        low = np.minimum(record[1:], record[:-1])
        high = np.maximum(record[1:], record[:-1])
        broken = table.curve[i].broken
        inside = (low <= observations.observed[i]) & (observations.observed[i] <= high)
        near = (low - reach <= observations.observed[i]) & (
            observations.observed[i] <= high + reach
        )
        ends = np.min(np.abs(record - observations.observed[i])) <= reach
        if np.any(inside & broken) and not np.any(near & ~broken) and not ends:
            found.append(observations.columns.event_id[i])
    return tuple(found)
