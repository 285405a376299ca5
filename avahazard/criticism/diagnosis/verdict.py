"""What the evidence for candidates amounts to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.screening.significance import Screened
from avahazard.effects.effect import Definition
from avahazard.inference.model.observations import Observations

MARGIN = 3.0
"""Evidence (nats) by which a candidate must lead the model without it to be named, and the next
candidate to be named alone: odds of 20 to 1."""


def verdict_of(named: Sequence[Definition]) -> tuple[str, tuple[str, ...]]:
    """What the leading candidates amount to: the verdict, and their keys."""
    keys = tuple(entry.key for entry in named)
    if not named:
        return "adequate", keys
    if not any(entry.names_cause for entry in named):
        return "unexplained", keys
    return "missing-effect" if len(named) == 1 else "ambiguous", keys


def least_evidence(entry: Definition) -> float:
    """Evidence (nats) that a candidate must have over the model without it to be named.

    For the smooth of a column none is enough: it names no cause, and its many free bends have cost
    it dear.
    """
    return MARGIN if entry.names_cause else 0.0


def evidence_gain(screened: Screened, fit: Refit, base: Refit) -> float:
    """Evidence (nats) that a candidate adds.

    The estimated limit of sight is that of the highest stop seen on each path: its likelihood
    rises with every path where nothing is hidden. Its price is that of its one parameter, or what
    it gains on average in made worlds, in the measure of the full fit, if that is more. Both are
    prices of the same limits, so that it pays one.
    """
    gain = fit.evidence - base.evidence
    if screened.definition.says_what_is_seen:
        likelier = fit.log_likelihood - base.log_likelihood
        share = likelier / max(screened.gain, 1e-9)
        gain = min(gain, likelier - screened.null_mean * min(max(share, 0.0), 1.0))
    return gain


def group_comes_first(
    observations: Observations, own: Sequence[Definition], base: Refit, rival: Refit, key: str
) -> bool:
    """Whether groups that differ (`key`) explain more, given a rival, than it given them.

    A rival that differs by path alone, as the section, may explain all that paths differ by.
    """
    bare = tuple(k for k in rival.specification.effects if k != key)
    alone = refit(
        observations, replace(rival.specification, effects=bare), rival.facts, (), own, rival
    )
    by_group = rival.log_likelihood - alone.log_likelihood
    by_rival = rival.log_likelihood - base.log_likelihood
    return by_group > by_rival


def groups_earn_their_name(
    observations: Observations, own: Sequence[Definition], base: Refit, key: str
) -> bool:
    """Whether groups that differ (`key`, which `base` has) have `MARGIN` of evidence.

    Several kinds of groups are tested, each by itself, beside all candidates: their p-values alone
    would name one too often.
    """
    bare = tuple(k for k in base.specification.effects if k != key)
    specification = replace(base.specification, effects=bare)
    without = refit(observations, specification, base.facts, (), own, base)
    return base.evidence - without.evidence > MARGIN
