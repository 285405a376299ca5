"""The friction that an event's own record asks for, in the light of the model."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_scatter import below, log_density
from avahazard.physics.runout_curve import MU

TINY = 1e-290


def friction_given_record(
    posterior: Posterior, nodes: Nodes, event: int, location: Floats, scatter: Floats
) -> tuple[Floats, Floats]:
    """Frictions `[n_nodes + 2]` and their chances (which sum to 1) given the record of one event.

    The last two stand for all below and beyond the tables, which a vague record allows.
    `nodes` are those of all events; `location` and `scatter` `[n_volumes]` are of this one.
    """
    in_log = posterior.layout.log_scatter
    place, weight = nodes.place[event], nodes.weight[event]
    if nodes.is_probability[event]:
        # It left the profile: any friction, by its chance to let it.
        edges, drops = place, weight
        place = np.log(MU) if in_log else MU
        chance = nodes.floor[event] + (edges > place[:, None]) @ drops
        weight = np.gradient(place) * np.clip(chance, 0.0, 1.0)
    student = posterior.specification.tails == "student"
    h = posterior.observations.volumes.weight[event]
    z = (place[:, None] - location) / scatter
    log_p = np.logaddexp.reduce(log_density(z, student) + np.log(h / scatter), axis=1)
    edge = nodes.tail_place[event]
    z = np.array([[1.0], [-1.0]]) * (edge[:, None] - location) / scatter
    log_beyond = np.log(np.maximum(below(z, student) @ h, TINY))
    log_p = np.concatenate([log_p, log_beyond])
    place = np.concatenate([place, edge])
    weight = np.concatenate([weight, nodes.tail[event]])
    top = np.max(log_p[weight > 0.0], initial=-np.inf)
    p = weight * np.exp(np.minimum(log_p - top, 0.0))
    if not np.sum(p) > 0.0:
        p = np.ones(len(place))
    return (np.exp(place) if in_log else place), p / np.sum(p)
