"""Which of the candidates that were fitted in full are named, and the verdict.

Effects that were declared before anybody looked come first. A name on the motion must have the
measured force as its witness where there is one.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from avahazard.criticism.diagnosis.force_witness import ForceWitness, force_witness
from avahazard.criticism.diagnosis.refits import (
    Question,
    Refit,
    held_out_gain,
    refit_with,
    refit_without,
)
from avahazard.criticism.scoring.speed_misfit import matched_speeds, speed_misfit
from avahazard.criticism.screening.linear_model import linear_model
from avahazard.criticism.screening.screen import Screened
from avahazard.effects.effect import Definition, MotionEffect, of_kind
from avahazard.effects.stretches import all_parts, build_stretches
from avahazard.inference.seeds import generator

MARGIN = 3.0
"""Evidence (nats) by which a candidate must lead the model without it to be named, and the next
candidate to be named alone: odds of 20 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Naming:
    """The verdict so far; held-out gains (nats) of those that were asked, and all witnesses."""

    verdict: str
    missing: tuple[str, ...]
    held_out: Mapping[str, float]
    witnesses: Mapping[str, ForceWitness]


def name_effects(
    question: Question,
    ranked: Sequence[Screened],
    evidence: Mapping[str, float],
    expected: Sequence[str] = (),
    of_laws: Mapping[str, Refit] = MappingProxyType({}),
) -> Naming:
    """Name the leaders that gain on held-out records and that the force does not deny.

    `ranked` are candidates that survived the screening, those of most `evidence` (nats) first;
    `of_laws` are the fits of those whose law predicts the held-out records for them.
    """
    fits = {**question.fits, **of_laws}
    asked = {key: _witness(fit, key, of_laws.get(key)) for key, fit in question.fits.items()}
    witnesses = {key: found for key, found in asked.items() if found is not None}
    declared = [c for c in ranked if c.key in expected and evidence[c.key] > 0.0]
    leading = leaders(declared, evidence, question.fits, expected)
    leading = leading or _undeclared(question, ranked, evidence, of_laws)
    gains = {c.key: held_out_gain(fits[c.key], question.base) for c in leading}
    named = [c for c in leading if gains[c.key] > 0.0 and evidence[c.key] > 0.0]
    denied = [c.key for c in named if c.key in witnesses and witnesses[c.key].denies]
    if named and named[0].key in denied:
        # What has most evidence is no force that acts: nobody knows yet what it makes up for.
        return Naming("unexplained", (worst_speeds(question.base),), gains, witnesses)
    verdict, missing = verdict_of([c.definition for c in named if c.key not in denied])
    return Naming(verdict, missing, gains, witnesses)


def _undeclared(
    question: Question,
    ranked: Sequence[Screened],
    evidence: Mapping[str, float],
    of_laws: Mapping[str, Refit],
) -> list[Screened]:
    """The leaders where nothing was declared beforehand: a detection limit is the last of them.

    What is missed in any other way narrows the stops of a path as well, so that a limit leads only
    where no other candidate has `MARGIN` of evidence beside it, and not on a model with effects
    that were added, as these leave something over.
    """

    def price(of: str) -> float:
        """What a candidate pays for its choice among others."""
        return max(question.fits[of].evidence - question.base.evidence - evidence[of], 0.0)

    def explains(simpler: str, key: str) -> bool:
        """Whether `key` has too little evidence beside a simpler candidate, or the law of that.

        Less what it pays beyond what the simpler one pays. Of two forces along the way, the smooth
        one has the other among its shapes.
        """
        fit = question.fits[simpler]
        if acts_on_motion(fit, simpler) and acts_on_motion(question.fits[key], key):
            return True
        more, fit = max(price(key) - price(simpler), 0.0), of_laws.get(simpler, fit)
        return refit_with(fit, key).evidence - fit.evidence - more <= MARGIN

    found = leaders(ranked, evidence, question.fits, explains=explains)
    if not found or not found[0].definition.says_what_is_seen:
        return found
    limit = found[0].key
    others = [c for c in ranked if c.key != limit and evidence[c.key] > MARGIN]
    others = [c for c in others if not explains(limit, c.key)]
    return leaders(others, evidence, question.fits, explains=explains) or (
        [] if was_added_to(question.base) else found
    )


def was_added_to(base: Refit) -> bool:
    """Whether a model has an effect that no diagnosis grants unasked."""
    return any(base.definition(key).nuisance is None for key in base.specification.effects)


def _witness(fit: Refit, key: str, by_law: Refit | None) -> ForceWitness | None:
    """What the measured force says of candidate `key`, by the fit of its law if there is one.

    No smooth follows a narrow band. It is given as a share of what the smooth was fitted as.
    """
    plain = force_witness(fit.posterior, fit.mode, key)
    if by_law is None or plain is None:
        return plain
    found = force_witness(by_law.posterior, by_law.mode, by_law.posterior.effects[-1].key)
    if found is None:
        return None
    times = plain.fitted / found.fitted
    return ForceWitness(times * found.value, abs(times) * found.se, plain.fitted)


def leaders(
    ranked: Sequence[Screened],
    evidence: Mapping[str, float],
    fits: Mapping[str, Refit] = MappingProxyType({}),
    expected: Sequence[str] = (),
    explains: Callable[[str, str], bool] = lambda _simpler, _key: True,
) -> list[Screened]:
    """The candidate of most evidence and those close to it; none where it is not enough.

    One that was declared beforehand needs no margin over the model without it: it was the only
    question. What leads over a simpler one must do so without any single event of `fits`; one close
    to it comes first where it `explains` the leader.
    """
    if not ranked:
        return []
    first = ranked[0]
    if evidence[first.key] <= (0.0 if first.key in expected else MARGIN):
        return []

    def behind(c: Screened) -> float:
        lead = evidence[first.key] - evidence[c.key]
        simpler = c.definition.beyond < first.definition.beyond
        if simpler and c.key in fits and first.key in fits:
            lead -= float(np.max(fits[first.key].by_event - fits[c.key].by_event))
        return lead

    close = [c for c in ranked if behind(c) < MARGIN]
    # What the catalogue explains as well is no new effect, nor a pair what one column explains.
    simpler = [c for c in close if c.definition.beyond < first.definition.beyond]
    simpler = [c for c in simpler if explains(c.key, first.key)]
    nearest = min(c.definition.beyond for c in simpler or [first])
    return [c for c in simpler or close if c.definition.beyond == nearest]


def acts_on_motion(fit: Refit, key: str) -> bool:
    """Whether an effect of the fit is a force along the way."""
    return any(effect.key == key for effect in of_kind(fit.posterior.effects, MotionEffect))


def worst_speeds(base: Refit) -> str:
    """The axis along which the speeds of the model fail most."""
    matched = matched_speeds(base.at_mode(), generator(0, "speeds of a fit"))
    assert matched is not None
    rows = speed_misfit(base.observations, matched)
    return f"speed:{max(rows, key=lambda row: abs(row.bias_m_s)).axis}"


def verdict_of(named: Iterable[Definition]) -> tuple[str, tuple[str, ...]]:
    """What the leading candidates amount to: the verdict, and their keys."""
    named = tuple(named)
    keys = tuple(entry.key for entry in named)
    if not named:
        return "adequate", keys
    if not any(entry.names_cause for entry in named):
        return "unexplained", keys
    return "missing-effect" if len(named) == 1 else "ambiguous", keys


def group_comes_first(base: Refit, rival: Refit, key: str) -> bool:
    """Whether groups that differ (`key`) explain more, given a rival, than it given them.

    A rival that differs by path alone, as the section, may explain all that paths differ by.
    """
    by_group = rival.log_likelihood - refit_without(rival, key).log_likelihood
    return by_group > rival.log_likelihood - base.log_likelihood


def evidence_beside_places(fit: Refit, key: str) -> float:
    """Evidence (nats) for effect `key`, the last of a fit, beside friction that varies by place.

    By the ratio of Savage and Dickey, to second order at the mode: the density of its parameters at
    neutral, given the records and before. Of an effect of the catalogue by its first parameter, of
    which the others are the shape. inf where it is no force, acts on single paths, or no path has
    tracks enough.

    Measured speeds err together: what a block lacks on a path it lacks on every track there, and
    peak speeds belong to a front. The likelihood gives each track friction that scatters along it,
    and a dozen tracks with the same fault then seem to be a dozen witnesses. So a force must have
    its evidence beside an addition to friction in each part of each path, common to its tracks and
    as large as the scatter along them.
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
    own, precision = model.own
    columns = np.column_stack([own[:, -n:], model.of_effect(places, places.neutral)])
    scatter = np.full(len(places.parameters), posterior.layout.track_sigma(u) ** -2.0)
    before = precision[-n:]
    weighed = model.projected(columns, but_last=n)
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
