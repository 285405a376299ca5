"""Designs of the model, its friction linear about a fit, and of alternatives on its tables.

They do not change between simulated datasets.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.effects.effect import Effect, FrictionEffect, VolumeErrorEffect, of_kind
from avahazard.inference.fitting.mode import units
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import OffsetPlan
from avahazard.inference.model.friction_scatter import volume_share
from avahazard.inference.model.laws import law
from avahazard.inference.model.volumes import VolumeNodes, rescaled

SCATTER_SLOPES = (-1.5, -0.8, -0.4, 0.4, 0.8, 1.5)
"""Slopes of log scatter over the reference volume that are tried."""
MOST_EXPONENT = 20.0

Weighed = tuple[Design, float]
"""A design, and its log prior against the neutral one."""


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


def with_columns(design: Design, effect: Effect, columns: Floats) -> Design:
    """The design with the columns of an effect on friction."""
    sd = np.array([p.prior_sd for p in effect.parameters])
    return design._replace(
        x=np.column_stack([design.x, columns]),
        prior_mean=np.append(design.prior_mean, np.zeros(len(sd))),
        prior_precision=np.append(design.prior_precision, sd**-2.0),
    )


def law_design(
    posterior: Posterior, at: Floats, name: str, design: Design, coefficients: Floats
) -> Design:
    """The design with another law, linear about its least-squares fit to the present one."""
    volumes = posterior.volumes(at)
    other = law(name)
    n_old = len(posterior.layout.law.coordinates)
    volume = volumes.volume
    weight = volumes.weight
    mu = np.exp(design.constant + design.x[:, :n_old] @ coefficients[:n_old])
    u = other.start(np.exp(volumes.mean), mu)
    if name == "power":
        u = np.array([np.log(np.median(mu)), 0.05])

    def mean(v: Floats) -> Floats:
        values = other.log_friction(v, volume.ravel()).reshape(volume.shape)
        return np.asarray(np.sum(values * weight, axis=1))

    columns = [(mean(u + step) - mean(u - step)) / 2e-3 for step in 1e-3 * np.eye(len(u))]
    x = np.column_stack([*columns, design.x[:, n_old:]])
    return design._replace(
        x=x,
        constant=mean(u) - np.column_stack(columns) @ u,
        prior_mean=np.append(other.prior_mean, design.prior_mean[n_old:]),
        prior_precision=np.append(other.prior_sd**-2.0, design.prior_precision[n_old:]),
    )


def scatter_slope_designs(volumes: VolumeNodes, design: Design) -> list[Weighed]:
    """Scatter that grows or falls with volume."""
    volume = np.exp(volumes.mean)
    share = volume_share(volume, float(np.quantile(volume, 0.9)))
    return [
        (
            design._replace(multiplier=design.multiplier * _grown(g * (share.mean() - share))),
            -0.5 * g * g,
        )
        for g in SCATTER_SLOPES
    ]


def _grown(exponent: Floats) -> Floats:
    """e to this power, kept a number where one volume dwarfs the rest."""
    return np.exp(np.clip(exponent, -MOST_EXPONENT, MOST_EXPONENT))


def volume_error_designs(
    effect: VolumeErrorEffect, posterior: Posterior, u: Floats, design: Design
) -> list[Weighed]:
    """True volumes read with other errors than the stated ones."""
    (p,) = effect.parameters
    octaves = np.log(2.0) * np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
    tried = [float(v) for v in octaves if v < p.high]
    if p.high > p.neutral:
        tried.append(p.high)
    result = []
    for v in tried:
        volumes = rescaled(posterior.volumes(u), effect.scale(np.array([v])))
        x, constant, extra, multiplier = read_by_volume(posterior, u, volumes)
        other = design._replace(x=x, constant=constant, extra=extra, multiplier=multiplier)
        log_prior = -0.5 * ((v - p.prior_mean) / p.prior_sd) ** 2
        result.append((other, log_prior))
    return result
