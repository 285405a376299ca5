"""What is granted before anything is blamed on physics: heavy tails, and groups of events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

HEAVY_TAILS = 3.0
"""Gain (nats) above which scatter is taken with Student's tails."""
ASKED_FOR = 0.5
"""Gain (nats) from which on the records ask for a nuisance: Akaike's price of a spread, which
chance lets grow in half of all cases only."""
MOST_CROSSED = 150
"""Offsets, besides those of the largest grouping, that are still fitted together."""


def with_tails_granted(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition],
) -> Refit:
    """The model fitted, with Student's tails where friction plainly scatters so."""
    plain = refit(observations, specification, facts, (), own)
    if specification.tails != "normal":
        return plain
    student = refit(observations, replace(specification, tails="student"), facts, (), own)
    return student if student.log_likelihood - plain.log_likelihood > HEAVY_TAILS else plain


def with_nuisances_granted(
    observations: Observations, plain: Refit, own: Sequence[Definition]
) -> tuple[Refit, tuple[str, ...]]:
    """The model with the nuisances that come before physics, and the keys of those added.

    Paths may always differ; of winters and storms, that which gains most comes first, and the
    other if it then still gains.
    """
    left = [
        entry
        for entry in catalogue().values()
        if entry.nuisance is not None
        and not plain.specification.has(entry)
        and entry.nuisance(observations.columns, observations.sites) is None
    ]
    granted = [entry.key for entry in left if entry.granted_unasked]
    base = plain
    if granted:
        base = refit(observations, plain.specification, plain.facts, granted, own, plain)
    asked = [entry.key for entry in left if not entry.granted_unasked]
    while asked:
        tried = {
            key: refit(observations, base.specification, base.facts, (key,), own, base)
            for key in asked
        }
        tried = {k: fit for k, fit in tried.items() if fit.posterior.plan.n_crossed <= MOST_CROSSED}
        gains = {key: fit.log_likelihood - base.log_likelihood for key, fit in tried.items()}
        asked = [key for key, gain in gains.items() if gain > ASKED_FOR]
        if asked:
            best = max(asked, key=gains.__getitem__)
            base = tried[best]
            granted.append(best)
            asked.remove(best)
    return base, tuple(granted)
