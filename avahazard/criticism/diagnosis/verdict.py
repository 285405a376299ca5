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
    rises with every path where nothing is hidden, which no price of one parameter makes good.
    What it gains on average in made worlds does, in the measure of the full fit.
    """
    key = screened.definition.key
    gain = fit.evidence - base.evidence
    if any(e.key == key and e.limit is not None for e in fit.posterior.effects):
        share = (fit.log_likelihood - base.log_likelihood) / max(screened.gain, 1e-9)
        gain -= screened.null_mean * min(max(share, 0.0), 1.0)
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
