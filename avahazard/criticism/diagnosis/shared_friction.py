"""What is left of a force beside friction that varies by place, alike for all tracks of a path.

Measured speeds err together: what a block lacks on a path it lacks on every track there, and peak
speeds belong to a front. The likelihood gives each track friction that scatters along it, and a
dozen tracks with the same fault then seem to be a dozen witnesses. So a force must have its
evidence beside an addition to friction in each part of each path, common to its tracks and as large
as the scatter along them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.screening.linear_model import linear_model
from avahazard.effects.effect import MotionEffect
from avahazard.effects.stretches import all_parts, build_stretches


def evidence_beside_places(fit: Refit, key: str) -> float:
    """Evidence (nats) for effect `key`, the last of a fit, beside friction that varies by place.

    By the ratio of Savage and Dickey, to second order at the mode: the density of its parameters at
    neutral, given the records and before. Of an effect of the catalogue by its first parameter, of
    which the others are the shape. inf where it is no force, acts on single paths, or no path has
    tracks enough.
    """
    kept = f"{key} beside places"
    if kept not in fit.kept:
        fit.kept[kept] = _beside_places(fit, key)
    return float(fit.kept[kept])


def _beside_places(fit: Refit, key: str) -> float:
    posterior, u = fit.posterior, fit.mode.u
    observations, effect = posterior.observations, next(reversed(posterior.effects), None)
    parts = all_parts(observations.columns, observations.sites)
    if not isinstance(effect, MotionEffect) or effect.key != key or effect.paths or parts is None:
        return np.inf
    model, n = linear_model(posterior, u), len(effect.parameters)
    places = build_stretches("places", parts)
    columns = np.column_stack([model.own[:, -n:], model.of_effect(places, places.neutral)])
    scatter = np.full(len(places.parameters), posterior.layout.track_sigma(u) ** -2.0)
    before = model.precision[-n:]
    rest = replace(model, own=model.own[:, :-n], precision=model.precision[:-n])
    weighed = rest.projected(columns)
    bend = weighed.T @ columns + np.diag(np.concatenate([before, scatter]))
    # At the mode the effect has no slope; the places have, and move it.
    slope = np.concatenate([np.zeros(n), weighed[:, n:].T @ model.residual])
    covariance = np.linalg.inv(bend)
    value = posterior.layout.effect_values(u)[key] - effect.neutral + (covariance @ slope)[:n]
    if not fit.definition(key).beyond:
        n = 1
    inner = covariance[:n, :n]
    quadratic = value[:n] @ np.linalg.solve(inner, value[:n])
    return 0.5 * float(quadratic + np.linalg.slogdet(inner)[1] + np.sum(np.log(before[:n])))
