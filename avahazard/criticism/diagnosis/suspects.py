"""Events whose record is hard to believe."""

from __future__ import annotations

import numpy as np

from avahazard.criticism.diagnosis.refits import Refit
from avahazard.inference.fitting.mode import likely_friction
from avahazard.records.doubts import dwarfing

FAR = 4.0
"""Scatters off, from which on a record is suspect."""


def suspects(base: Refit) -> tuple[str, ...]:
    """Events whose volume dwarfs all others, then those more than `FAR` scatters off, worst first.

    A slip of units in a volume bends the law until its event lies on it.
    """
    posterior = base.posterior
    location, scatter = posterior.location_and_scatter(base.mode.u)
    friction = likely_friction(posterior.nodes.at(base.mode.u), posterior.layout.log_scatter)
    asked = np.log(friction) if posterior.layout.log_scatter else friction
    z = np.nan_to_num(np.abs(asked - location.mean(axis=1)) / scatter.mean(axis=1))
    order = np.argsort(-z, kind="stable")
    columns = posterior.observations.columns
    found = [*dwarfing(columns.log_volume), *(i for i in order if z[i] > FAR)]
    return tuple(dict.fromkeys(columns.event_id[i] for i in found))
