"""Whether paths differ in friction by more than a model without a path effect knows.

Such a model takes what differs between paths for scatter between avalanches, and its quantiles for
one path lie too close together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import MIN_SPREAD
from avahazard.inference.prediction.fitted_model import FittedModel

WORTH_A_NOTE = float(np.log(3.0))
"""Evidence (nats) from which on paths are said to differ: three to one."""
LARGEST, N_SPREADS = 4.0, 24
"""The spread τ is tried up to that many scales of its prior, closer together where it is small."""
STEP, LONGEST, ROUNDS = 0.1, 0.4, 2


@dataclass(frozen=True, slots=True)
class PathsDiffer:
    """Spread between paths: posterior mean of τ on log friction, and evidence for it (nats).

    `effect` is the effect that would take it up; `lacking` says why it cannot be added, if so.
    """

    sd: float
    evidence: float
    n_paths: int
    effect: str
    lacking: str | None


def paths_differ(model: FittedModel) -> PathsDiffer | None:
    """What the records say of a spread between paths that `model` does not have.

    None where it has one, where there is one path, or for the paper's methods. The evidence is
    ∫ L(τ) p(τ) dτ / L(0), where L is the likelihood with the scatter at its best for each τ and
    the law as calibrated; offsets of paths are integrated out. The law held, it is a little less
    (by a nat or two) than that of the model fitted with its path effect, and takes half a second.
    """
    columns = model.observations.columns
    n_paths = len(np.unique(columns.path_index[columns.path_index >= 0]))
    entry = _definition()
    if not model.knows_errors or n_paths < 2 or model.specification.has(entry):
        return None
    wider = _with_spread(model, entry)
    layout = wider.layout
    place = layout.spreads[entry.key]
    scale = layout.slots[place].scale
    known = dict(
        zip((s.name for s in model.posterior.layout.slots), model.draws.mean(axis=0), strict=True)
    )
    u = np.array([known.get(slot.name, 0.0) for slot in layout.slots])
    least = MIN_SPREAD / scale
    spreads = least + LARGEST * np.linspace(0.0, 1.0, N_SPREADS) ** 2
    profile = np.empty(N_SPREADS)
    for k, spread in enumerate(spreads):
        u[place] = spread
        profile[k], u[layout.scatter] = _best_scatter(wider, u)
    # The prior of τ is half-normal; it is in the density up to its constant.
    prior = -0.5 * spreads**2
    log_weight = profile + np.log(np.gradient(spreads)) + 0.5 * np.log(2.0 / np.pi)
    base = profile[0] - prior[0]
    mean = float(np.exp(logsumexp(log_weight, b=spreads) - logsumexp(log_weight)))
    return PathsDiffer(
        sd=scale * mean,
        evidence=float(logsumexp(log_weight) - base),
        n_paths=n_paths,
        effect=entry.key,
        lacking=entry.lacking(columns, model.observations.sites),
    )


def _definition() -> Definition:
    return next(entry for entry in catalogue().values() if entry.granted_unasked)


def _with_spread(model: FittedModel, entry: Definition) -> Posterior:
    """The posterior with offsets of paths, on the grids of the model."""
    specification = model.specification
    return Posterior(
        model.observations,
        replace(specification, effects=(*specification.effects, entry.key)),
        (*model.posterior.effects, entry.build({})),
        {slot.name: slot.grid for slot in model.posterior.layout.slots if slot.grid},
    )


def _best_scatter(posterior: Posterior, u: Floats) -> tuple[float, float]:
    """Largest log density over the log scatter, and where; by parabolas from that of `u`."""
    place = posterior.layout.scatter
    low, high = posterior.layout.low[place] + STEP, posterior.layout.high[place] - STEP
    middle, tried = float(np.clip(u[place], low, high)), {}

    def density(at: float) -> float:
        if at not in tried:
            v = u.copy()
            v[place] = at
            tried[at] = posterior.log_density(v)
        return tried[at]

    for _ in range(ROUNDS):
        behind, here, ahead = (density(middle + k * STEP) for k in (-1, 0, 1))
        bend = behind + ahead - 2.0 * here
        slope = 0.5 * (ahead - behind)
        move = -slope / bend * STEP if bend < 0.0 else np.sign(slope) * LONGEST
        middle = float(np.clip(middle + np.clip(move, -LONGEST, LONGEST), low, high))
        density(middle)
    best = max(tried, key=lambda at: tried[at])
    return tried[best], best
