"""What is granted before anything is blamed on physics, and whether a calibrated model lacks it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.refits import Refit, refit, refit_each, refit_with
from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import Definition, Effect, Facts
from avahazard.inference.fitted_model import FittedModel, in_slots
from avahazard.inference.fitting.mode import ascent
from avahazard.inference.likelihood.assemble import build_effects, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import offset_plan
from avahazard.inference.model.layout import MIN_SPREAD
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.notes import Note

HEAVY_TAILS = 3.0
"""Gain (nats) above which scatter is taken with Student's tails."""
ASKED_FOR = 0.5
"""Gain (nats) from which on the records ask for a nuisance: Akaike's price of a spread, which
chance lets grow in half of all cases only."""
MOST_CROSSED = 150
"""Offsets, besides those of the largest grouping, that are still fitted together."""
MODE_STEPS = 40
WORTH_A_NOTE = float(np.log(3.0))
"""Evidence (nats) from which on paths are said to differ: three to one."""
LARGEST, N_SPREADS = 4.0, 24
"""The spread τ is tried up to that many scales of its prior, closer together where it is small."""
STEP, LONGEST, ROUNDS = 0.1, 0.4, 2


def with_tails_granted(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition],
    known: Floats | None = None,
) -> Refit:
    """The model fitted (from `known`), with Student's tails where friction plainly scatters so."""
    plain = refit(observations, specification, facts, (), own, known=known)
    if specification.tails != "normal":
        return plain
    tails = replace(specification, tails="student")
    student = refit(observations, tails, facts, (), own, plain)
    return student if student.log_likelihood - plain.log_likelihood > HEAVY_TAILS else plain


def with_nuisances_granted(plain: Refit) -> tuple[Refit, tuple[str, ...], tuple[str, ...]]:
    """The model with the nuisances that come before physics; the keys of these, and of others.

    Paths may always differ; of winters and storms, that which gains most comes first, and the
    other if it then still gains. Groups that are crossed with others in more than `MOST_CROSSED`
    offsets are not granted: nobody has asked the records about these.
    """
    data = plain.observations.columns, plain.observations.sites
    left = [
        entry
        for entry in catalogue().values()
        if entry.nuisance is not None
        and not plain.specification.has(entry)
        and entry.nuisance(*data) is None
    ]
    granted = [entry.key for entry in left if entry.granted_unasked]
    base = refit_with(plain, *granted) if granted else plain
    asked = [entry.key for entry in left if not entry.granted_unasked]
    too_many: list[str] = []
    while asked:
        too_many += [k for k in asked if _n_crossed(base, k) > MOST_CROSSED]
        asked = [k for k in asked if k not in too_many]
        tried = refit_each(base, asked)
        gains = {key: fit.log_likelihood - base.log_likelihood for key, fit in tried.items()}
        asked = [key for key, gain in gains.items() if gain > ASKED_FOR]
        if asked:
            best = max(asked, key=gains.__getitem__)
            base = tried[best]
            granted.append(best)
            asked.remove(best)
    return base, tuple(granted), tuple(too_many)


def without_those_asked_for(base: Refit, specification: Specification) -> Refit | None:
    """The model less tails, winters and storms that the records ask for; None where it has none."""
    kept = tuple(
        key
        for key in base.specification.effects
        if key in specification.effects or base.definition(key).granted_unasked
    )
    bare = replace(base.specification, tails=specification.tails, effects=kept)
    if bare == base.specification:
        return None
    return refit(base.observations, bare, base.facts, (), base.own, base)


def _n_crossed(base: Refit, key: str) -> int:
    """Offsets besides those of the largest grouping, were these groups granted too."""
    wider, more = with_effects(base.observations, base.specification, (key,), granted=True)
    effects = build_effects(wider, {**base.facts, **more}, base.own)
    return int(np.sum(offset_plan(effects, base.observations.columns).rest >= 0))


def heavier_tails(model: FittedModel) -> float | None:
    """What Student's tails gain (nats of log likelihood) over the normal ones of `model`.

    None where it has them, or for the paper's methods. Effects and spreads of groups stay as
    calibrated, so that it is a little less than that of the models fitted in full.
    """
    if not model.knows_errors or model.specification.tails != "normal":
        return None
    student = _on_its_grids(model, (), tails="student")
    return _best(*student) - _best(model.posterior, model.draws.mean(axis=0))


def _on_its_grids(
    model: FittedModel, more: tuple[Effect, ...], **changes: Any
) -> tuple[Posterior, Floats]:
    """The posterior with other settings and `more` effects, on the star of the model.

    And the posterior mean of the model in its coordinates.
    """
    before, specification = model.posterior, replace(model.specification, **changes)
    effects = (*before.effects, *more)
    found = Posterior(model.observations, specification, effects, before.layout.arms)
    names, mean = [slot.name for slot in before.layout.slots], model.draws.mean(axis=0)
    return found, in_slots(found.layout, names, mean[None])[0]


def _best(posterior: Posterior, u: Floats) -> float:
    """Log likelihood at the best law, scatter and share of wrong records from u on."""
    layout = posterior.layout
    free = [*range(len(layout.law.coordinates)), layout.scatter]
    if layout.wrong_share is not None:
        free.append(layout.wrong_share)
    start = np.clip(u, layout.low, layout.high)
    at, _ = ascent(posterior, start, np.array(free), MODE_STEPS)
    return float(posterior.log_likelihood(at))


def paths_differ(model: FittedModel, name: str) -> Note | None:
    """The note on a spread between paths that `model` does not have, with its evidence (nats).

    None where it has one, where there is one path, or for the paper's methods. The evidence is ∫
    L(τ) p(τ) dτ / L(0), L with the scatter at its best for each τ and the law as calibrated: a nat
    or two less than that of the model fitted with its path effect.
    """
    columns = model.observations.columns
    n_paths = len(np.unique(columns.path_index[columns.path_index >= 0]))
    entry = next(entry for entry in catalogue().values() if entry.granted_unasked)
    if not model.knows_errors or n_paths < 2 or model.specification.has(entry):
        return None
    keys = (*model.specification.effects, entry.key)
    wider, u = _on_its_grids(model, (entry.build({}),), effects=keys)
    layout = wider.layout
    place = layout.spreads[entry.key]
    scale = layout.slots[place].scale
    spreads = MIN_SPREAD / scale + LARGEST * np.linspace(0.0, 1.0, N_SPREADS) ** 2
    profile = np.empty(N_SPREADS)
    for k, spread in enumerate(spreads):
        u[place] = spread
        profile[k], u[layout.scatter] = _best_scatter(wider, u)
    # The prior of τ is half-normal; it is in the density up to its constant.
    prior = -0.5 * spreads**2
    log_weight = profile + np.log(np.gradient(spreads)) + 0.5 * np.log(2.0 / np.pi)
    base = profile[0] - prior[0]
    mean = float(np.exp(logsumexp(log_weight, b=spreads) - logsumexp(log_weight)))
    evidence = float(logsumexp(log_weight) - base)
    remedy = Note("add_effect", model=name, effect=entry.key)
    if entry.lacking(columns, model.observations.sites):
        remedy = Note("too_few_paths", n=n_paths)
    return Note("paths_differ", sd=scale * mean, nats=evidence, model=name, remedy=remedy)


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
