"""The design of the model itself: its friction, linear about a fit.

Designs do not change between made worlds.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.effects.effect import FrictionEffect, of_kind
from avahazard.inference.fitting.units import units
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import OffsetPlan
from avahazard.inference.model.volumes import VolumeNodes


def base_design(posterior: Posterior, u: Floats, plan: OffsetPlan, scale: Floats) -> Design:
    """Design of the model itself: its law, linear about u, and its effects on friction.

    Offsets of groups are those of `plan`, their spreads have half-normal priors of this `scale`
    `[n_groupings]`.
    """
    slots = [posterior.layout.slots[k] for k in _inner(posterior)]
    x, constant, extra, multiplier = read_by_volume(posterior, u, posterior.volumes(u))
    return Design(
        x=x,
        constant=constant,
        prior_mean=np.array([s.mean for s in slots]),
        prior_precision=np.array([s.sd**-2.0 for s in slots]),
        of=plan.of,
        places=plan.index,
        alone=plan.alone,
        rest=plan.rest,
        spread_scale=scale,
        extra=extra,
        multiplier=multiplier,
        log_wrong=_odds_of_wrong(posterior, u),
    )


def base_coordinates(posterior: Posterior, u: Floats) -> Floats:
    """The values at u of the coefficients of `base_design`."""
    return np.asarray(u[_inner(posterior)])


def read_by_volume(
    posterior: Posterior, u: Floats, volumes: VolumeNodes
) -> tuple[Floats, Floats, Floats, Floats]:
    """The `x`, `constant`, `extra` and `multiplier` of a design, given the true volumes."""
    inner = _inner(posterior)
    mean = _mean_log_friction(posterior, u, volumes)
    x = np.empty((posterior.observations.n_events, len(inner)))
    small = 1e-4 * units(posterior)
    for c, k in enumerate(inner):
        step = np.zeros(len(u))
        step[k] = small[k]
        up, down = (_mean_log_friction(posterior, u + d, volumes) for d in (step, -step))
        x[:, c] = (up - down) / (2.0 * small[k])
    _, scatter = posterior.location_and_scatter(u, volumes.volume)
    middle = np.exp(np.average(np.log(scatter), axis=1, weights=volumes.weight[0]))
    return (
        x,
        mean - x @ u[inner],
        _volume_variance(posterior, u, volumes),
        middle / np.exp(np.mean(np.log(middle))),
    )


def _inner(posterior: Posterior) -> list[int]:
    """Slots of the coefficients; effects on the tables and on the errors keep their values."""
    inner = list(range(len(posterior.layout.law.coordinates)))
    for effect in of_kind(posterior.effects, FrictionEffect):
        place = posterior.layout.places[effect.key]
        inner += list(range(place.start, place.stop))
    return inner


def _odds_of_wrong(posterior: Posterior, u: Floats) -> Floats:
    """`Posterior.log_wrong` over the share of records that are right."""
    place = posterior.layout.wrong_share
    right = 0.0 if place is None else float(np.log1p(-np.exp(u[place])))
    return np.asarray(posterior.log_wrong(u) - right)


def _mean_log_friction(posterior: Posterior, u: Floats, volumes: VolumeNodes) -> Floats:
    location, _ = posterior.location_and_scatter(u, volumes.volume)
    if not posterior.layout.log_scatter:
        location = np.log(np.maximum(location, 1e-3))
    return np.asarray(np.sum(location * volumes.weight, axis=1))


def _volume_variance(posterior: Posterior, u: Floats, volumes: VolumeNodes) -> Floats:
    location, _ = posterior.location_and_scatter(u, volumes.volume)
    weight = volumes.weight
    mean = np.sum(location * weight, axis=1, keepdims=True)
    return np.asarray(np.sum((location - mean) ** 2 * weight, axis=1))
