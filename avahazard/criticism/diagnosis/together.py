"""Effects that are needed together: beside the one that was named, or only with each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from avahazard.criticism.diagnosis.force_witness import force_witness
from avahazard.criticism.diagnosis.naming import MARGIN, least_evidence
from avahazard.criticism.diagnosis.record_faults import explained_by_record_faults
from avahazard.criticism.diagnosis.refits import (
    Question,
    Refit,
    likely_values,
    refit_each,
    refit_with,
)
from avahazard.criticism.screening.candidates import candidate_definitions
from avahazard.criticism.screening.screen import LEVEL, PAIR_LEVEL, screen

MOST = 3
"""Effects that are named together at most."""
TRIED = 2
"""Candidates beside those already chosen that are fitted in full."""


@dataclass(frozen=True, slots=True, eq=False)
class Together:
    """Effects fitted together; gains in nats.

    `gain` is that over the model without them, `gain_over_best_single` that over the best of
    them alone, both of log likelihood; `p_value` is that of the last one beside the others, or of
    a pair of which neither shows alone.
    """

    effects: tuple[str, ...]
    fit: Refit
    gain: float
    gain_over_best_single: float
    p_value: float


def needed_beside(question: Question, first: str) -> tuple[Together, ...]:
    """What else is needed once `first` is in the model: a pair, and from it a triple.

    A candidate counts where its gain beside those already chosen would be significant as the best
    of all in the simulated datasets of the screening, and where the model with it has `MARGIN` of
    evidence over that without, gains on held-out records, and is not better without any of the
    others. One that faults of the records explain as well is not needed.
    """
    base, observations = question.base, question.base.observations
    singles = dict(question.fits)
    fit = singles[first]
    chosen: tuple[str, ...] = (first,)
    found: list[Together] = []
    while len(chosen) < MOST:
        entries = candidate_definitions(observations, fit.specification, base.own)
        beside = screen(fit.posterior, fit.mode.u, entries).candidates
        p_values = {c.key: c.p_family for c in beside}
        tried = [c.key for c in beside if c.p_family <= LEVEL][:TRIED]
        likely = likely_values((c for c in beside if c.key in tried), observations)
        wider = refit_each(fit, tried, likely=likely)
        best = _best_needed(replace(question, base=fit, fits=wider))
        if best is None:
            break
        if best not in singles:
            singles[best] = refit_with(base, best)
        if wider[best].evidence - singles[best].evidence <= MARGIN:
            break  # the new one does it alone
        fit, chosen = wider[best], (*chosen, best)
        found.append(_together(chosen, fit, base, singles, p_values[best]))
    return tuple(found)


def _best_needed(question: Question) -> str | None:
    """The candidate of most evidence beside the base that nothing else explains, if needed."""
    wider = question.fits
    for key in sorted(wider, key=lambda k: -wider[k].evidence):
        if not _is_needed(question.base, wider[key], (key,)):
            return None
        if not explained_by_record_faults(question, key):
            return key
    return None


def masked_pair(question: Question) -> Together | None:
    """Two effects that count together where neither does alone, if the screening found such."""
    test, base = question.screening.pair, question.base
    if test is None or test.p_value > PAIR_LEVEL:
        return None
    singles = refit_each(base, test.keys)
    both = refit_with(base, *test.keys)
    alone = max((base, *singles.values()), key=lambda fit: fit.evidence)
    if not _is_needed(alone, both, test.keys):
        return None
    order = tuple(sorted(test.keys, key=lambda k: -singles[k].evidence))
    return _together(order, both, base, singles, test.p_value)


def _together(
    keys: tuple[str, ...], fit: Refit, base: Refit, singles: Mapping[str, Refit], p_value: float
) -> Together:
    best = max(singles[k].log_likelihood for k in keys)
    gain = fit.log_likelihood - base.log_likelihood
    return Together(keys, fit, gain, fit.log_likelihood - best, p_value)


def _is_needed(fit: Refit, wider: Refit, more: Sequence[str]) -> bool:
    """Whether a wider model is worth it: by evidence, by held-out records, by the force."""
    least = max(least_evidence(wider.definition(k)) for k in more)
    if wider.evidence - fit.evidence <= least:
        return False
    witnesses = [force_witness(wider.posterior, wider.mode, k) for k in more]
    if any(w is not None and w.denies for w in witnesses):
        return False
    return bool(np.sum(wider.held_out - fit.held_out) > 0.0)
