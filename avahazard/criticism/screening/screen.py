"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the Laplace fit's log likelihood rises when it is added, law,
scatter and offsets of groups fitted again. Its null distribution comes from worlds made on the
user's own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.chance_gains import WorldGains, gains_by_chance
from avahazard.criticism.screening.group_spreads import GroupSpreads
from avahazard.criticism.screening.levels import LEVEL, PAIR_LEVEL, group_level
from avahazard.criticism.screening.masked_pairs import Paired
from avahazard.criticism.screening.parametric_bootstrap import real_world
from avahazard.criticism.screening.significance import PairTest, Screening, judge
from avahazard.criticism.screening.tested_model import TestedModel, tested_model
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.posterior import Posterior

BATCH = 40
"""Worlds made before it is asked whether more are needed."""
AT_ONCE = 2
"""Batches that are made at once where each look at the candidates makes tables anew."""


def screen(
    posterior: Posterior,
    u: Floats,
    spreads: GroupSpreads,
    candidates: Sequence[Definition],
    *,
    expected: Sequence[str] = (),
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Screening:
    """Screen the candidates on a model at its mode u, less its groups of events.

    `spreads` are those of the groups, which are granted as nuisances; `expected` the keys of
    candidates that were declared beforehand.

    At most `n_worlds` worlds are made, fewer where it is soon plain that chance does as well
    (the sequential test of Besag and Clifford 1991, whose p-values stay valid). Equal seeds give
    equal results for any number of workers.
    """
    tested = tested_model(posterior, u, spreads, candidates, records_alone=False)
    looked: list[WorldGains] = []
    found = None
    while found is None or (found.n_worlds < n_worlds and not _enough(found, n_worlds)):
        # The records come before the first world.
        first = len(looked) - 1
        at_once = AT_ONCE if looked and not tested.gains.alternatives.all_held else 1
        numbers = range(first, min(max(first, 0) + at_once * BATCH, n_worlds))
        looked += gains_by_chance(tested, seed, numbers, progress, n_worlds)
        for n in [*range(max(first, 0) + BATCH, numbers.stop, BATCH), numbers.stop]:
            found = _judged(tested, candidates, expected, looked[: n + 1])
            if _enough(found, n_worlds):
                break
    return found


def _judged(
    tested: TestedModel,
    candidates: Sequence[Definition],
    expected: Sequence[str],
    looked: Sequence[WorldGains],
) -> Screening:
    """The gains on the records, which come first, beside those on the worlds made so far."""
    beside = [each.beside for each in looked]
    gains = np.array([each.of_candidates for each in looked])
    groups = np.array([each.of_groupings for each in beside])
    plan = tested.spreads.plan
    told = [(k, group_level(lasts)) for k, lasts in zip(plan.keys, plan.lasting, strict=True)]
    limit = np.array([each.limit for each in beside])
    found = judge(candidates, gains, limit, told, groups, expected)
    pair = beside[0].pair
    if pair is None:
        return found
    null = [0.0 if each.pair is None else each.pair.surprise for each in beside[1:]]
    return replace(found, pair=_pair_test(pair, null, candidates))


def _pair_test(real: Paired, null: Sequence[float], candidates: Sequence[Definition]) -> PairTest:
    """The most surprising pair beside those of the made worlds."""
    p = (1.0 + float(np.sum(np.array(null) >= real.surprise))) / (len(null) + 1.0)
    return PairTest((candidates[real.first].key, candidates[real.second].key), real.surprise, p)


def gains_beside(
    posterior: Posterior, u: Floats, spreads: GroupSpreads, candidates: Sequence[Definition]
) -> dict[str, float]:
    """What each candidate gains (nats) on the records beside all that a model at its mode has.

    Arguments as in `screen`.
    """
    tested = tested_model(posterior, u, spreads, candidates, records_alone=True)
    records = real_world(posterior)
    (gains,) = tested.gains.of_candidates([records], [tested.gains.reference(records)])
    return {c.key: float(gain) for c, gain in zip(candidates, gains, strict=True)}


def _enough(found: Screening, n_worlds: int) -> bool:
    """Whether chance plainly does as well.

    Twice as many made worlds have exceeded the records as could in all of them if these were to be
    significant.
    """
    best = min((c.p_family for c in found.candidates), default=1.0)
    levels = [(best, LEVEL), *((group.p_value, group.level) for group in found.groups)]
    if found.pair is not None:
        levels.append((found.pair.p_value, PAIR_LEVEL))
    return all(p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1) for p, level in levels)
