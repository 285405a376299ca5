"""Candidates that stand out, fitted in full, and groups of events: what they gain by chance.

The screening tells to first order what each candidate gains. An effect that is strong, or shapes
the tables as only a larger amount does, gains more than that once it is fitted, so its p-value is
that of the larger gain.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy import stats

from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import (
    Likely,
    Refit,
    likely_values,
    refit_each,
    refit_without,
    short_climb,
)
from avahazard.criticism.diagnosis.two_kinds import CHANCE_GAIN, gain_of_wrong_records
from avahazard.criticism.screening.screen import EXPECTED_SHARE, LEVEL, Screened, Screening
from avahazard.effects.effect import Definition, FrictionEffect, LimitEffect
from avahazard.effects.record import VOLUME_ERROR
from avahazard.inference.model.observations import Observations

FITTED, OF_A_FAMILY = 7, 2
"""Candidates that are fitted in full at most, and of one family beyond the catalogue."""
BY_PATH = 3
"""Of those that differ by path alone, however little they gain to first order."""
WORTH_A_FIT = float(-np.log(0.2))
"""Surprise of the screening from which on a candidate is."""
WORTH_BESIDE = 0.5
"""Share of the largest gain to first order that a candidate must have to be fitted beside it."""
WORTH_INSTEAD = 0.7
"""Share of the evidence for groups that a candidate must gain to first order to be tried in their
place."""
PERSISTENT_LEVEL, TRANSIENT_LEVEL = 0.003, 0.001
"""Levels of groups of events, each tested by itself: of those that persist, as paths, of winters
and of storms, which must have evidence besides."""


@dataclass(frozen=True, slots=True)
class TriedGroup:
    """An effect on groups of events, by its key: its gain (nats) beside the others, its p-value.

    `evidence` (nats) is that for the groups, `spread` how far they differ; those that are
    `lasting`, as paths, come again.
    """

    key: str
    gain: float
    p_value: float
    lasting: bool
    evidence: float
    spread: float

    @property
    def level(self) -> float:
        """What the p-value is held against."""
        return PERSISTENT_LEVEL if self.lasting else TRANSIENT_LEVEL


def fitted_in_full(
    base: Refit,
    screening: Screening,
    alone: Sequence[Definition],
    expected: Sequence[str] = (),
    known: Mapping[str, Refit] = MappingProxyType({}),
    progress: Callable[[float], None] = lambda _share: None,
) -> tuple[dict[str, Refit], Screening]:
    """The candidates that stand out, fitted (but those `known`), and the screening with p-values.

    `alone` are candidates that no screening can try, tested by themselves;
    `expected` the keys of those that were declared beforehand. These are a family of their own,
    with two thirds of the level; the others have the rest of it, and all of it once every expected
    one is significant (the fallback procedure, Wiens 2003).
    """
    observations = base.observations
    likely = likely_values(screening.candidates, observations)
    strong = [_strong(c, likely, base) for c in screening.candidates]
    likely = likely_values(strong, observations)
    screening = replace(screening, candidates=tuple(sorted(strong, key=lambda c: -c.surprise)))
    worth: list[str] = []
    families: Counter[str] = Counter()
    least = WORTH_BESIDE * max((c.gain for c in screening.candidates), default=0.0)
    for c in screening.candidates:
        families[c.definition.family] += 1
        rare = not c.definition.beyond or families[c.definition.family] <= OF_A_FAMILY
        if rare and c.surprise > WORTH_A_FIT and c.gain >= least and len(worth) < FITTED:
            worth.append(c.key)
    by_path = [c.key for c in screening.candidates if _by_path(c.definition, observations)]
    # To first order larger errors of the volumes may gain a fifth of what they do, or nothing.
    errors = [c.key for c in screening.candidates if c.key == VOLUME_ERROR.key]
    keys = [*expected, *(d.key for d in alone), *worth, *by_path[:BY_PATH], *errors]
    keys = list(dict.fromkeys(keys))
    asked = [key for key in keys if key not in known]
    fits = {**known, **refit_each(base, asked, progress, likely)}
    gains = {key: fit.log_likelihood - base.log_likelihood for key, fit in fits.items()}
    tested = [_fitted(c, gains.get(c.key)) for c in screening.candidates]
    tested += [_alone(d, fits[d.key], gains[d.key]) for d in alone]
    declared = [c for c in tested if c.key in expected]
    p_values = {
        c.key: min(np.exp(-c.surprise) * len(declared) / EXPECTED_SHARE, 1.0) for c in declared
    }
    share = 1.0
    if any(p > LEVEL for p in p_values.values()):
        share = 1.0 - EXPECTED_SHARE
    for c in tested:
        level = c.definition.level_alone
        p = c.p_single * LEVEL / level if level else screening.p_family(c.surprise, share)
        p_values.setdefault(c.key, min(p, 1.0))
    ranked = sorted(tested, key=lambda c: (p_values[c.key], -c.surprise))
    found = tuple(replace(c, p_family=float(p_values[c.key])) for c in ranked)
    return fits, replace(screening, candidates=found)


def _strong(candidate: Screened, likely: Likely, base: Refit) -> Screened:
    """The candidate with the gain of a short climb and its values, where it shapes the tables.

    What gains much is far from neutral, where the tables are no longer linear in it: with speeds
    even the sign of its score may mislead there.
    """
    known = bool(base.observations.speeds) and not candidate.definition.beyond
    if (candidate.surprise <= WORTH_A_FIT and not known) or candidate.key not in likely:
        return candidate
    gain, values = short_climb(base, candidate.key, likely[candidate.key])
    return _fitted(replace(candidate, likely=values), gain)


def _by_path(entry: Definition, observations: Observations) -> bool:
    """Whether a candidate on friction differs by path alone.

    What paths differ by takes its place to first order, until it is fitted and that goes.
    """
    if entry.changes is not None:
        return False
    effect = entry.build(entry.facts(observations.columns, observations.sites))
    if not isinstance(effect, FrictionEffect):
        return False
    design, path = effect.design(observations.columns), observations.columns.path_index
    return all(not np.any(np.ptp(design[path == k], axis=0)) for k in np.unique(path))


def _fitted(candidate: Screened, gain: float | None) -> Screened:
    """The candidate with what its full fit gains, if that is more surprising."""
    if gain is None or candidate.surprise_of(gain) <= candidate.surprise:
        return candidate
    return replace(candidate, gain=gain, surprise=candidate.surprise_of(gain))


def _alone(entry: Definition, fit: Refit, gain: float) -> Screened:
    """A candidate that has no score at neutral: what it gains by chance is known.

    Two kinds of avalanche gain what `CHANCE_GAIN` says. A limit of detection just above the highest
    stop of a path makes every record there likelier: by -n log U of n stops, where the share U that
    lies below the highest has the distribution of the largest of n, so by an exponential's one nat
    a path, whatever n is.
    """
    observations = fit.observations
    effect = next(e for e in fit.posterior.effects if e.key == entry.key)
    shape, scale = 1.0, CHANCE_GAIN
    if isinstance(effect, LimitEffect):
        lowest = np.array([p.low for p in effect.parameters])
        limited = np.isfinite(effect.limit(observations.columns, lowest))
        limited &= np.isnan(observations.limit)
        shape, scale = len(np.unique(observations.columns.path_index[limited])) + 0.5, 1.0
    found = Screened(entry, gain, shape, scale, False, 0.0, 1.0, np.empty(0))
    return replace(found, surprise=found.surprise_of(gain))


def group_tests(base: Refit) -> tuple[TriedGroup, ...]:
    """Each of the granted groups beside the others; a spread that is 0 lies at its bound."""
    plan, found = base.posterior.plan, []
    spreads = base.posterior.layout.spread_values(base.mode.u)
    for key, lasts, spread in zip(plan.keys, plan.lasting, spreads, strict=True):
        without = refit_without(base, key)
        gain = max(base.log_likelihood - without.log_likelihood, 0.0)
        p_value = 0.5 * float(stats.chi2.sf(2.0 * gain, 1))
        evidence = base.evidence - without.evidence
        found.append(TriedGroup(key, gain, p_value, lasts, evidence, float(spread)))
    return tuple(found)


def plainly_different(
    base: Refit, groups: Sequence[TriedGroup], granted: Sequence[str]
) -> list[TriedGroup]:
    """The granted groups with the evidence of any cause, the plainest first.

    Groups that are too few to estimate their spread are never among them.
    """
    data = base.observations.columns, base.observations.sites
    plain = [
        test
        for test in groups
        if test.key in granted
        and test.evidence > MARGIN
        and test.p_value <= test.level
        and base.definition(test.key).lacking(*data) is None
    ]
    return sorted(plain, key=lambda test: -test.gain)


def explained_otherwise(
    without: Refit, screening: Screening, group: TriedGroup
) -> dict[str, Refit]:
    """Candidates fitted in place of groups that differ, if one has their evidence less `MARGIN`.

    A change at a date makes winters differ, and a force at one elevation paths: granted first, such
    groups take up most of what the cause would gain. `without` is the model without them, and
    `screening` that of all candidates on it. None where no candidate has that evidence, or it does
    not gain on held-out records.
    """
    worth = [
        c
        for c in screening.candidates
        if c.p_family <= LEVEL and c.gain > WORTH_INSTEAD * group.evidence
    ]
    worth = sorted(worth, key=lambda c: -c.gain)[:OF_A_FAMILY]
    likely = likely_values(worth, without.observations)
    fits = refit_each(without, [c.key for c in worth], likely=likely)
    found = any(
        evidence_gain(c, fits, without, screening) > group.evidence - MARGIN
        and np.sum(fits[c.key].held_out - without.held_out) > 0.0
        for c in worth
    )
    return fits if found else {}


def evidence_gain(
    candidate: Screened, fits: Mapping[str, Refit], base: Refit, screening: Screening
) -> float:
    """Evidence (nats) that a candidate adds.

    Never more than it gains in likelihood: where another law has other priors it would be. The
    estimated detection limit has a price of a nat a path, what it gains on average by chance. One
    of many of a kind, or of many dates, is as likely beforehand as they are together. Two kinds of
    avalanche must explain more than wrong records do.
    """
    entry = candidate.definition
    price = 0.0
    if entry.beyond and entry.names_cause:
        price = np.log(sum(c.definition.family == entry.family for c in screening.candidates))
        if entry.alternatives is not None:
            data = base.observations.columns, base.observations.sites
            price += np.log(len(entry.alternatives(*data)))
    fit = fits[candidate.key]
    gain = fit.log_likelihood - base.log_likelihood
    if fit.posterior.layout.kinds is not None and base.posterior.layout.kinds is None:
        price += gain_of_wrong_records(base)
    if candidate.definition.says_what_is_seen:
        gain -= candidate.shape
    return float(min(fit.evidence - base.evidence, gain) - price)
