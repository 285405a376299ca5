"""Which of the candidates that were fitted in full are named, and the verdict.

Effects that were declared before anybody looked come first. A name on the motion must have the
measured force as its witness where there is one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from avahazard.criticism.diagnosis.force_witness import ForceWitness, force_witness
from avahazard.criticism.diagnosis.refits import Refit, held_out_gain, refit_without
from avahazard.criticism.scoring.speed_misfit import matched_speeds, speed_misfit
from avahazard.criticism.screening.screen import Screened
from avahazard.effects.effect import Definition
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
    ranked: Sequence[Screened],
    evidence: Mapping[str, float],
    fits: Mapping[str, Refit],
    base: Refit,
    expected: Sequence[str] = (),
) -> Naming:
    """Name the leaders that gain on held-out records and that the force does not deny.

    `ranked` are candidates that survived the screening, those of most `evidence` (nats) first.
    """
    witnesses = {
        key: found
        for key, fit in fits.items()
        if (found := force_witness(fit.posterior, fit.mode, key)) is not None
    }
    declared = [c for c in ranked if c.key in expected and evidence[c.key] > 0.0]
    asked = leaders(declared, evidence, expected) or leaders(ranked, evidence)
    gains = held_out_gains([c.key for c in asked], fits, base)
    named = [c for c in asked if gains[c.key] > 0.0 and evidence[c.key] > 0.0]
    denied = [c.key for c in named if c.key in witnesses and witnesses[c.key].denies]
    if named and named[0].key in denied:
        # What has most evidence is no force that acts: nobody knows yet what it makes up for.
        return Naming("unexplained", (worst_speeds(base),), gains, witnesses)
    verdict, missing = verdict_of([c.definition for c in named if c.key not in denied])
    return Naming(verdict, missing, gains, witnesses)


def leaders(
    ranked: Sequence[Screened], evidence: Mapping[str, float], expected: Sequence[str] = ()
) -> list[Screened]:
    """The candidate of most evidence and those close to it; none where it is not enough.

    One that was declared beforehand needs no margin over the model without it: it was the only
    question.
    """
    if not ranked:
        return []
    first = ranked[0]
    if evidence[first.key] <= (0.0 if first.key in expected else MARGIN):
        return []
    close = [c for c in ranked if evidence[first.key] - evidence[c.key] < MARGIN]
    # What the catalogue explains as well is no new effect, nor a pair what one column explains.
    nearest = min(c.definition.beyond for c in close)
    return [c for c in close if c.definition.beyond == nearest]


def held_out_gains(
    asked: Sequence[str], fits: Mapping[str, Refit], base: Refit
) -> dict[str, float]:
    """What each of these gains on held-out records (nats)."""
    return {key: held_out_gain(fits[key], base) for key in asked}


def worst_speeds(base: Refit) -> str:
    """The axis along which the speeds of the model fail most."""
    matched = matched_speeds(base.at_mode(), generator(0, "speeds of a fit"))
    assert matched is not None
    spread: dict[str, float] = {}
    for row in speed_misfit(base.posterior.observations, matched):
        spread[row.axis] = max(spread.get(row.axis, 0.0), abs(row.bias_m_s))
    return f"speed:{max(spread, key=lambda axis: spread[axis])}"


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


def groups_earn_their_name(fit: Refit, key: str) -> bool:
    """Whether groups that differ (`key`, which `fit` has) have `MARGIN` of evidence.

    Several kinds of groups are tested, each by itself, beside all candidates: their p-values alone
    would name one too often.
    """
    return fit.evidence - refit_without(fit, key).evidence > MARGIN
