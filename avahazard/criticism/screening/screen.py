"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the Laplace fit's log likelihood rises when it is added, law,
scatter and offsets of groups fitted again. Its null distribution comes from worlds made on the
user's own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.screening.alternatives import (
    Alternative,
    alternatives_of,
    base_coordinates,
    base_design,
    make_tables,
)
from avahazard.criticism.screening.gains import Gains
from avahazard.criticism.screening.group_spreads import GroupSpreads
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.masked_pairs import Paired, effect_columns
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
from avahazard.effects.effect import Definition
from avahazard.engine import spread_map
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted, predict_records, run_blocks
from avahazard.inference.seeds import generator

Floats = NDArray[np.float64]

BATCH = 40
"""Worlds made before it is asked whether more are needed."""
MAKING_READY = 0.3
"""Share of the time that it takes to spell out the candidates."""


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
    tested = _what_is_tested(
        posterior, u, spreads, candidates, lambda s: progress(MAKING_READY * s)
    )
    records = real_world(posterior)
    n_groupings = len(spreads.tau)
    real = _gains_on(tested, records, [records] * n_groupings)
    null, null_groups = np.empty((0, len(candidates))), np.empty((0, n_groupings))
    null_pairs: list[float] = []
    while len(null) < n_worlds:
        made = _gains_by_chance(tested, seed, range(len(null), min(len(null) + BATCH, n_worlds)))
        null = np.concatenate([null, [gains.of_candidates for gains in made]])
        null_groups = np.concatenate([null_groups, [gains.of_groupings for gains in made]])
        null_pairs += [0.0 if gains.pair is None else gains.pair.surprise for gains in made]
        found = judge(
            candidates,
            real.of_candidates,
            null,
            spreads.plan.keys,
            real.of_groupings,
            null_groups,
            expected,
        )
        if real.pair is not None:
            found = replace(found, pair=_pair_test(real.pair, null_pairs, candidates))
        progress(MAKING_READY + (1.0 - MAKING_READY) * len(null) / n_worlds)
        if _chance_plainly_does_as_well(found, n_worlds):
            break
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Tested:
    """A model at its mode `u`, what it predicts, and the gains of every candidate on any records.

    `without` `[n_groupings]` are the designs that grant all groupings but one.
    """

    posterior: Posterior
    u: Floats
    spreads: GroupSpreads
    speed_scatter: float
    predicted: Predicted
    gains: Gains
    without: tuple[Design, ...]


class _WorldGains(NamedTuple):
    """What candidates `[n_candidates]`, groupings `[n_groupings]`, a pair gain on one world."""

    of_candidates: Floats
    of_groupings: Floats
    pair: Paired | None


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
    tested = _what_is_tested(posterior, u, spreads, candidates, lambda _share: None)
    gains = tested.gains.of_candidates(real_world(posterior))
    return {c.key: float(gain) for c, gain in zip(candidates, gains, strict=True)}


def _what_is_tested(
    posterior: Posterior,
    u: Floats,
    spreads: GroupSpreads,
    candidates: Sequence[Definition],
    progress: Callable[[float], None],
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
    alternatives: list[Alternative] = []
    for k, entry in enumerate(candidates):
        alternatives += alternatives_of(
            entry, posterior, u, base, design, coefficients, speed_scatter, runs
        )
        progress((k + 1) / len(candidates))
    keys = [c.key for c in candidates]
    columns = effect_columns(base, design, alternatives, {key: k for k, key in enumerate(keys)})
    gains = Gains(
        base,
        design,
        alternatives,
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
    return _Tested(posterior, u, spreads, speed_scatter, predicted, gains, without)


def _gains_on(
    tested: _Tested, records: BootstrapRecords, records_of_groupings: Sequence[BootstrapRecords]
) -> _WorldGains:
    """Gains of the candidates on records, and of each grouping on its own."""
    of_groupings = [
        tested.gains.of_grouping(g, own, without)
        for g, (own, without) in enumerate(zip(records_of_groupings, tested.without, strict=True))
    ]
    return _WorldGains(
        tested.gains.of_candidates(records),
        np.array(of_groupings, np.float64),
        tested.gains.of_pair(records),
    )


def _gains_by_chance(tested: _Tested, seed: int, worlds: Iterable[int]) -> list[_WorldGains]:
    """Gains on worlds in which the model is true, each by its own seed."""
    return list(spread_map(_gains_on_made_world, (tested, seed), worlds))


def _gains_on_made_world(shared: tuple[_Tested, int], world: int) -> _WorldGains:
    """Gains in one made world; that of each grouping where its groups do not differ.

    What its groups had shared is then scatter of the events by themselves, or such worlds would
    vary less than the records do.
    """
    tested, seed = shared
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
        )

    tau = spreads.drawn(rng)
    records = made(tau, tested.u)
    alike = [
        made(np.where(np.arange(len(tau)) == g, 0.0, tau), _with_scatter(tested, spreads.tau[g]))
        for g in range(len(tau))
    ]
    return _gains_on(tested, records, alike)


def _with_scatter(tested: _Tested, tau: float) -> Floats:
    """The coordinates with the spread `tau` of groups put into the scatter of the events."""
    layout = tested.posterior.layout
    u = tested.u.copy()
    if layout.log_scatter:
        u[layout.scatter] = 0.5 * np.log(np.exp(2.0 * u[layout.scatter]) + tau**2)
    return u


def _chance_plainly_does_as_well(found: Screening, n_worlds: int) -> bool:
    """Whether chance is plainly enough.

    Twice as many made worlds have exceeded the records as could in all of them if these were to be
    significant.
    """
    best = min((c.p_family for c in found.candidates), default=1.0)
    levels = [(best, LEVEL), *((group.p_value, GROUP_LEVEL) for group in found.groups)]
    if found.pair is not None:
        levels.append((found.pair.p_value, PAIR_LEVEL))
    return all(p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1) for p, level in levels)
