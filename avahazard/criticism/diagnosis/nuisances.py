"""What is granted before anything is blamed on physics: heavy tails, and groups of events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from avahazard.criticism.diagnosis.refits import Refit, refit, refit_each
from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import build_effects, with_effects
from avahazard.inference.model.friction_model import offset_plan
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


class Nuisances(NamedTuple):
    """The model with the nuisances that come before physics, by key those added, and those not.

    `too_many` are crossed with other groups in more than `MOST_CROSSED` offsets: nobody has asked
    the records about these.
    """

    base: Refit
    granted: tuple[str, ...]
    too_many: tuple[str, ...]


def with_nuisances_granted(
    observations: Observations, plain: Refit, own: Sequence[Definition]
) -> Nuisances:
    """The nuisances that come before physics, granted.

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
    too_many: list[str] = []
    while asked:
        too_many += [k for k in asked if _n_crossed(observations, base, k, own) > MOST_CROSSED]
        asked = [k for k in asked if k not in too_many]
        tried = refit_each(observations, asked, own, base)
        gains = {key: fit.log_likelihood - base.log_likelihood for key, fit in tried.items()}
        asked = [key for key, gain in gains.items() if gain > ASKED_FOR]
        if asked:
            best = max(asked, key=gains.__getitem__)
            base = tried[best]
            granted.append(best)
            asked.remove(best)
    return Nuisances(base, tuple(granted), tuple(too_many))


def _n_crossed(observations: Observations, base: Refit, key: str, own: Sequence[Definition]) -> int:
    """Offsets besides those of the largest grouping, were these groups granted too."""
    wider, more = with_effects(observations, base.specification, (key,), own, granted=True)
    effects = build_effects(wider, {**base.facts, **more}, own)
    return offset_plan(effects, observations.columns).n_crossed
