"""Which gains are more than chance: p-values by themselves and family-wise.

A gain is turned into a p-value of its own by a gamma distribution fitted to the simulated datasets,
and the smallest of these into a family-wise one by their distribution over the simulated datasets
(Westfall and Young 1993). Where nothing is missing something is named in at most 5 of 100 cases:
that is what the levels of all that can lead to a name add up to, however the tests depend on each
other (Bonferroni).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition

LEVEL = 0.03
"""Family-wise level of the candidates."""
EXPECTED_SHARE = 2.0 / 3.0
"""Share of that level for candidates that were expected before anybody looked."""
PERSISTENT_LEVEL, TRANSIENT_LEVEL = 0.003, 0.001
"""Levels of groups of events, each tested by itself: of those that persist, as paths, of winters
and of storms, which must have evidence besides."""
DETECTION_LEVEL = 0.01
"""Level of what says which avalanches were recorded at all, tested by itself."""
PAIR_LEVEL = 0.005
"""Level of pairs of which neither shows alone."""
CHANCE_SHARE = 0.5
"""Share of `limit_by_chance` that is left out of the test of a detection limit: all of it is chance
where nothing is hidden, some of it is not where much is."""
MIN_POSITIVE = 15
"""Gains in simulated datasets from which on a gamma distribution is fitted to them."""


@dataclass(frozen=True, slots=True)
class Screened:
    """A candidate after the screening.

    Its gain (nats), its p-values by itself and family-wise, and the gain that it has in one of
    twenty datasets where nothing is missing, and on average.
    """

    definition: Definition
    gain: float
    p_single: float
    p_family: float
    null_gain: float
    null_mean: float

    @property
    def key(self) -> str:
        """The effect's key."""
        return self.definition.key


@dataclass(frozen=True, slots=True)
class GroupTest:
    """An effect on groups of events, by its key: its gain (nats) beside the others, its p-value.

    `level` is what the p-value is held against.
    """

    key: str
    gain: float
    p_value: float
    level: float


@dataclass(frozen=True, slots=True)
class PairTest:
    """Two candidates that gain together what neither does alone, the most surprising such pair.

    `surprise` is that of `masked_pairs`; the p-value is against the largest of each simulated
    dataset, whose pairs are searched in the same way.
    """

    keys: tuple[str, str]
    surprise: float
    p_value: float


@dataclass(frozen=True, slots=True, eq=False)
class Chance:
    """Gains of the candidates by chance, `null` `[n_worlds, n_candidates]`.

    `largest` `[n_worlds]` is the surprise of the most surprising one of each simulated dataset.
    """

    keys: tuple[str, ...]
    null: Floats
    largest: Floats

    def family_wise(self, key: str, gain: float) -> float:
        """p-value of a gain of candidate `key` as the best of all; 1 for one not screened."""
        if key not in self.keys:
            return 1.0
        own = _surprise(self.null[:, self.keys.index(key)], np.array([gain]))[0]
        return (1.0 + float(np.sum(self.largest >= own))) / (len(self.largest) + 1.0)


@dataclass(frozen=True, slots=True)
class Screening:
    """All candidates, best first, the groups that are granted, and what chance does.

    `critical_gain` is what chance exceeds with one
    parameter, by some candidate, in a share `LEVEL` of simulated datasets.
    """

    candidates: tuple[Screened, ...]
    groups: tuple[GroupTest, ...]
    critical_gain: float
    n_worlds: int
    chance: Chance
    pair: PairTest | None = None


def group_level(persistent: bool) -> float:
    """Level of the test of groups that persist, as paths, or do not come again."""
    return PERSISTENT_LEVEL if persistent else TRANSIENT_LEVEL


def judge(
    candidates: Sequence[Definition],
    gains: Floats,
    limit: Floats,
    groups: Sequence[tuple[str, float]],
    group_gains: Floats,
    expected: Sequence[str] = (),
) -> Screening:
    """All candidates by their gains on the records, which come first, and on simulated datasets.

    Candidates `expected` before anybody looked are a family of their own, with two thirds of the
    level; the others have the rest of it, and all of it once every expected one is significant (the
    fallback procedure, Wiens 2003). What says which avalanches are detected is tested by itself, at
    `DETECTION_LEVEL`, less a share of the `limit` `[1 + n_worlds]` that is chance
    (`limit_by_chance`). p-values are divided by their share of `LEVEL`, against which all are held.

    `gains` `[1 + n_worlds, n_candidates]`, and `group_gains` of effects on `groups`, by key and
    level.
    """
    real, null = gains[0], gains[1:]
    n_worlds = len(null)
    limits = np.array([c.says_what_is_seen for c in candidates], np.bool_)
    tested = gains - CHANCE_SHARE * np.outer(limit, limits)
    surprise = np.column_stack([_surprise(t[1:], t[1:]) for t in tested.T])
    alone = limits & np.array([c.key not in expected for c in candidates], np.bool_)
    others = surprise[:, ~alone]
    largest = others.max(axis=1) if others.shape[1] else np.zeros(n_worlds)
    own = [float(_surprise(t[1:], t[:1])[0]) for t in tested.T]
    families = _family_wise(surprise, own, [c.key in expected for c in candidates], alone)
    result = []
    for k, entry in enumerate(candidates):
        s, family = own[k], families[k]
        chance = float(np.quantile(null[:, k], 0.95))
        mean = float(np.mean(null[:, k]))
        result.append(Screened(entry, float(real[k]), float(np.exp(-s)), family, chance, mean))
    result.sort(key=lambda c: (c.p_single, -c.gain))
    return Screening(
        candidates=tuple(result),
        groups=tuple(
            GroupTest(key, float(g[0]), float(np.exp(-_surprise(g[1:], g[:1])[0])), level)
            for (key, level), g in zip(groups, group_gains.T, strict=True)
        ),
        critical_gain=_critical_gain(largest),
        n_worlds=n_worlds,
        chance=Chance(tuple(c.key for c in candidates), null, largest),
    )


def _family_wise(
    surprise: Floats,
    own: Sequence[float],
    declared: Sequence[bool],
    alone: NDArray[np.bool_],
) -> list[float]:
    """Family-wise p-values of candidates that are as surprising as `own` `[n_candidates]`."""

    def of(members: NDArray[np.int64], factor: float) -> dict[int, float]:
        largest = surprise[:, members].max(axis=1)
        n = len(largest) + 1.0
        return {
            int(k): min(factor * (1.0 + float(np.sum(largest >= own[k]))) / n, 1.0) for k in members
        }

    first = np.flatnonzero(declared)
    rest = np.flatnonzero(~(np.asarray(declared, np.bool_) | alone))
    found: dict[int, float] = {}
    factor = 1.0
    if len(first):
        found = of(first, 1.0 / EXPECTED_SHARE)
        if max(found.values()) > LEVEL:
            factor = 1.0 / (1.0 - EXPECTED_SHARE)
    if len(rest):
        found |= of(rest, factor)
    for k in map(int, np.flatnonzero(alone)):
        # By rank: a few wild gains in simulated datasets would widen any curve fitted to them.
        found |= of(np.array([k]), LEVEL / DETECTION_LEVEL)
    return [found[k] for k in range(len(own))]


def _critical_gain(largest: Floats) -> float:
    """Gain of a parameter that some candidate exceeds in a share `LEVEL` of simulated datasets."""
    surprise = float(np.quantile(largest, 1.0 - LEVEL))
    return 0.5 * float(stats.chi2.isf(np.exp(-surprise), 1))


def _surprise(null: Floats, gains: Floats) -> Floats:
    """-log p of gains: none in many simulated datasets, else gamma with the moments of the others.

    No gain is taken as more surprising than that of one free parameter, whose double is χ² with
    one degree of freedom: a short tail must not be drawn out from a few small gains.
    """
    positive = null[null > 1e-6]
    share = (1.0 + len(positive)) / (1.0 + len(null))
    tail = stats.chi2.logsf(2.0 * np.maximum(gains, 0.0), 1)
    if len(positive) >= MIN_POSITIVE:
        mean, variance = float(np.mean(positive)), float(np.var(positive))
        gamma = stats.gamma.logsf(gains, mean**2 / variance, scale=variance / mean)
        tail = np.maximum(tail, gamma)
    return np.where(gains > 1e-6, -(np.log(share) + tail), 0.0)
