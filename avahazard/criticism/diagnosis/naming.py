"""Which of the candidates that were fitted in full are named, and what that amounts to.

Effects that were declared before anybody looked come first. A name on the motion must have the
measured force as its witness where there is one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.criticism.diagnosis.force_witness import ForceWitness, force_witness
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.verdict import MARGIN, least_evidence, verdict_of
from avahazard.criticism.scoring.speed_misfit import matched_speeds, speed_misfit
from avahazard.criticism.screening.significance import Screened
from avahazard.inference.seeds import generator


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
    """Name the leaders that gain on records kept back and that the force does not deny.

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
        # What has most evidence is no force that acts: nobody knows yet what it mends.
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
    least = 0.0 if first.key in expected else least_evidence(first.definition)
    if evidence[first.key] <= least:
        return []
    return [c for c in ranked if evidence[first.key] - evidence[c.key] < MARGIN]


def held_out_gains(
    asked: Sequence[str], fits: Mapping[str, Refit], base: Refit
) -> dict[str, float]:
    """What each of these gains on records kept back (nats)."""
    return {key: float(np.sum(fits[key].kept_back - base.kept_back)) for key in asked}


def worst_speeds(base: Refit) -> str:
    """The axis along which the speeds of the model fail most."""
    matched = matched_speeds(base.at_mode(), generator(0, "speeds of a fit"))
    assert matched is not None
    spread: dict[str, float] = {}
    for row in speed_misfit(base.posterior.observations, matched):
        spread[row.axis] = max(spread.get(row.axis, 0.0), abs(row.bias_m_s))
    return f"speed:{max(spread, key=lambda axis: spread[axis])}"
