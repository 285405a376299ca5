"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the Laplace fit's log likelihood rises when it is added, law,
scatter and offsets of groups fitted again. Its null distribution comes from worlds made on the
user's own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.screening.alternatives import AtHand, alternatives_of
from avahazard.criticism.screening.gains import Gains
from avahazard.criticism.screening.group_spreads import GroupSpreads
from avahazard.criticism.screening.held_alternatives import HeldAlternatives
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.masked_pairs import Paired, effect_columns
from avahazard.criticism.screening.model_design import base_coordinates, base_design
from avahazard.criticism.screening.parametric_bootstrap import (
    BootstrapRecords,
    make_world,
    real_world,
)
from avahazard.criticism.screening.significance import (
    GROUP_LEVEL,
    LEVEL,
    PAIR_LEVEL,
    PairTest,
    Screening,
    judge,
)
from avahazard.criticism.screening.tables import make_tables
from avahazard.effects.effect import Definition
from avahazard.engine import spread_map
from avahazard.engine.choice import LOCAL, chosen
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted, predict_records, run_blocks
from avahazard.inference.seeds import generator
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.workers import ordered_map

Floats = NDArray[np.float64]

BATCH = 40
"""Worlds made before it is asked whether more are needed."""
PART = 10
"""Worlds that are given to a worker of another process at once."""
CURVES = 500
"""Curves that are looked through together."""
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
    tested = _what_is_tested(posterior, u, spreads, candidates)
    looked: list[_WorldGains] = []
    found = None
    while found is None or (found.n_worlds < n_worlds and not _enough(found, n_worlds)):
        # The records come before the first world.
        first = len(looked) - 1
        at_once = AT_ONCE if looked and not tested.gains.alternatives.all_held else 1
        numbers = range(first, min(max(first, 0) + at_once * BATCH, n_worlds))
        looked += _gains_by_chance(tested, seed, numbers, progress, n_worlds)
        for n in [*range(max(first, 0) + BATCH, numbers.stop, BATCH), numbers.stop]:
            found = _judged(tested, candidates, expected, looked[: n + 1])
            if _enough(found, n_worlds):
                break
    return found


def _judged(
    tested: _Tested,
    candidates: Sequence[Definition],
    expected: Sequence[str],
    looked: Sequence[_WorldGains],
) -> Screening:
    """The gains on the records, which come first, beside those on the worlds made so far."""
    beside = [each.beside for each in looked]
    gains = np.array([each.of_candidates for each in looked])
    groups = np.array([each.of_groupings for each in beside])
    keys = tested.spreads.plan.keys
    found = judge(candidates, gains[0], gains[1:], keys, groups[0], groups[1:], expected)
    pair = beside[0].pair
    if pair is None:
        return found
    null = [0.0 if each.pair is None else each.pair.surprise for each in beside[1:]]
    return replace(found, pair=_pair_test(pair, null, candidates))


@dataclass(frozen=True, slots=True, eq=False)
class _Tested:
    """A model at its mode `u`, what it predicts, and the gains of every candidate on any records.

    `without` `[n_groupings]` are the designs that grant all groupings but one, `broken`
    `[n_events, n_friction - 1]` the cells over which F jumps.
    """

    posterior: Posterior
    u: Floats
    spreads: GroupSpreads
    speed_scatter: float
    predicted: Predicted
    broken: NDArray[np.bool_]
    gains: Gains
    without: tuple[Design, ...]


class _Beside(NamedTuple):
    """What groupings `[n_groupings]`, and the best pair of candidates, gain on one world."""

    of_groupings: Floats
    pair: Paired | None


class _World(NamedTuple):
    """One made world, and all but the candidates' own gains on it."""

    records: BootstrapRecords
    beside: _Beside


class _WorldGains(NamedTuple):
    """What candidates `[n_candidates]`, and all else that is asked, gain on one world."""

    of_candidates: Floats
    beside: _Beside


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
    tested = _what_is_tested(posterior, u, spreads, candidates)
    (gains,) = tested.gains.of_candidates([real_world(posterior)])
    return {c.key: float(gain) for c, gain in zip(candidates, gains, strict=True)}


def _what_is_tested(
    posterior: Posterior,
    u: Floats,
    spreads: GroupSpreads,
    candidates: Sequence[Definition],
) -> _Tested:
    """The model's tables and design, and each candidate spelled out."""
    observations, layout = posterior.observations, posterior.layout
    speed_scatter = 0.0 if layout.speed_scatter is None else float(np.exp(u[layout.speed_scatter]))
    values, curvature = layout.effect_values(u), float(posterior.specification.centrifugal)
    runs = run_blocks(observations, posterior.effects, values, curvature)
    predicted = predict_records(observations, posterior.effects, values, curvature, runs)
    base = make_tables(observations, predicted, observations.limit, speed_scatter)
    design = base_design(posterior, u, spreads.plan, spreads.scale)
    coefficients = base_coordinates(posterior, u)
    spelled = [
        spell
        for entry in candidates
        for spell in alternatives_of(
            entry, posterior, u, base, design, coefficients, speed_scatter, runs
        )
    ]
    keys = [c.key for c in candidates]
    at_hand = [a for spell in spelled if isinstance(spell, AtHand) for a in spell()]
    columns = effect_columns(base, design, at_hand, {key: k for k, key in enumerate(keys)})
    gains = Gains(
        base,
        design,
        HeldAlternatives(spelled, base),
        keys,
        coefficients,
        float(u[layout.scatter]),
        spreads.tau,
        posterior.specification.tails == "student",
        observations,
        columns,
    )
    without = tuple(
        base_design(posterior, u, spreads.plan.without((key,)), np.delete(spreads.scale, g))
        for g, key in enumerate(spreads.plan.keys)
    )
    broken = _broken(predicted.curve)
    return _Tested(posterior, u, spreads, speed_scatter, predicted, broken, gains, without)


def _broken(curve: RunoutCurve) -> NDArray[np.bool_]:
    """The broken cells of many curves, some at a time: what it takes on the way is large."""
    firsts = range(0, len(curve.x), CURVES)
    return np.concatenate([curve[k : k + CURVES].broken for k in firsts])


def _gains_beside(
    tested: _Tested, records: BootstrapRecords, records_of_groupings: Sequence[BootstrapRecords]
) -> _Beside:
    """Gains of each grouping on records of its own, and of the best pair of candidates."""
    of_groupings = [
        tested.gains.of_grouping(g, own, without)
        for g, (own, without) in enumerate(zip(records_of_groupings, tested.without, strict=True))
    ]
    return _Beside(np.array(of_groupings, np.float64), tested.gains.of_pair(records))


def _gains_by_chance(
    tested: _Tested,
    seed: int,
    numbers: range,
    progress: Callable[[float], None],
    n_worlds: int,
) -> list[_WorldGains]:
    """Gains on worlds in which the model is true, each by its own seed; -1 are the records."""
    if chosen().name == LOCAL:
        return _gains_on((tested, seed), numbers, lambda s: progress(_share(numbers, s, n_worlds)))
    # Each worker goes through the candidates with the worlds that it has.
    parts = [numbers[k : k + PART] for k in range(0, len(numbers), PART)]
    looked: list[_WorldGains] = []
    for k, part in enumerate(spread_map(_gains_on, (tested, seed), parts)):
        looked += part
        progress(_share(numbers, (k + 1) / len(parts), n_worlds))
    return looked


def _share(numbers: range, share: float, n_worlds: int) -> float:
    """How much is done with this share of these worlds."""
    done = max(numbers.start, 0)
    return (done + share * (numbers.stop - done)) / n_worlds


def _gains_on(
    shared: tuple[_Tested, int],
    numbers: range,
    progress: Callable[[float], None] = lambda _share: None,
) -> list[_WorldGains]:
    tested, seed = shared
    worlds = list(ordered_map(partial(_world, tested, seed), numbers))
    gains = tested.gains.of_candidates([world.records for world in worlds], progress)
    return [_WorldGains(g, world.beside) for g, world in zip(gains, worlds, strict=True)]


def _world(tested: _Tested, seed: int, number: int) -> _World:
    """One made world, or the records themselves (-1)."""
    if number >= 0:
        return _made_world(tested, seed, number)
    records = real_world(tested.posterior)
    alike = [records] * len(tested.spreads.tau)
    return _World(records, _gains_beside(tested, records, alike))


def _made_world(tested: _Tested, seed: int, world: int) -> _World:
    """A world in which the model is true, and the gain of each grouping where its groups are alike.

    What its groups had shared is then scatter of the events by themselves, or such worlds would
    vary less than the records do.
    """
    rng = generator(seed, "screening", world)
    spreads = tested.spreads

    def made(tau: Floats, u: Floats) -> BootstrapRecords:
        return make_world(
            tested.posterior,
            tested.predicted,
            u,
            spreads.plan,
            tau,
            tested.speed_scatter,
            rng,
            tested.broken,
        )

    tau = spreads.drawn(rng)
    records = made(tau, tested.u)
    alike = [
        made(np.where(np.arange(len(tau)) == g, 0.0, tau), _with_scatter(tested, spreads.tau[g]))
        for g in range(len(tau))
    ]
    return _World(records, _gains_beside(tested, records, alike))


def _with_scatter(tested: _Tested, tau: float) -> Floats:
    """The coordinates with the spread `tau` of groups put into the scatter of the events."""
    layout = tested.posterior.layout
    u = tested.u.copy()
    if layout.log_scatter:
        u[layout.scatter] = 0.5 * np.log(np.exp(2.0 * u[layout.scatter]) + tau**2)
    return u


def _enough(found: Screening, n_worlds: int) -> bool:
    """Whether chance plainly does as well.

    Twice as many made worlds have exceeded the records as could in all of them if these were to be
    significant.
    """
    best = min((c.p_family for c in found.candidates), default=1.0)
    levels = [(best, LEVEL), *((group.p_value, GROUP_LEVEL) for group in found.groups)]
    if found.pair is not None:
        levels.append((found.pair.p_value, PAIR_LEVEL))
    return all(p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1) for p, level in levels)
