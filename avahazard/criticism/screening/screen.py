"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the Laplace fit's log likelihood rises when it is added, law,
scatter and offsets of groups fitted again. Its null distribution comes from datasets made on the
user's own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.screening.candidates import HeldAlternatives, ModelAtMode, alternatives_of
from avahazard.criticism.screening.designs import base_coordinates, base_design
from avahazard.criticism.screening.gains import Gains, Paired, Reference, effect_columns
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.parametric_bootstrap import (
    BootstrapRecords,
    GroupSpreads,
    actual_records,
    simulate,
)
from avahazard.criticism.screening.significance import (
    LEVEL,
    PAIR_LEVEL,
    PairTest,
    Screening,
    group_level,
    judge,
)
from avahazard.criticism.screening.tables import make_tables
from avahazard.effects.effect import Definition
from avahazard.engine import LOCAL, chosen, spread_map
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import (
    Predicted,
    predict_records,
    run_blocks,
    sight_is_limited,
)
from avahazard.inference.likelihood.track_nodes import squares
from avahazard.inference.seeds import generator
from avahazard.workers import ordered_map

BATCH = 40
"""Datasets made before it is asked whether more are needed."""
AT_ONCE = 2
"""Batches that are made at once where each look at the candidates makes tables anew."""
PART = 10
"""Datasets that are given to a worker of another process at once."""
CURVES = 500
"""Curves that are looked through together."""


class DatasetGains(NamedTuple):
    """What all that is asked gains on one dataset.

    Candidates `[n_candidates]`, groupings `[n_groupings]`, the best pair of candidates, and limits
    of detection where nothing is fitted anew (`limit_by_chance`).
    """

    of_candidates: Floats
    of_groupings: Floats
    pair: Paired | None
    limit: float


@dataclass(frozen=True, slots=True, eq=False)
class TestedModel:
    """A model at its mode `u`, what it predicts, and the gains of every candidate on any records.

    `without` `[n_groupings]` are the designs that grant all groupings but one, `broken`
    `[n_events, n_friction - 1]` the cells over which F jumps, `square` the u² of each track.
    """

    posterior: Posterior
    u: Floats
    spreads: GroupSpreads
    track_scatter: float
    predicted: Predicted
    broken: NDArray[np.bool_]
    square: tuple[Floats, ...]
    gains: Gains
    without: tuple[Design, ...]


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

    At most `n_worlds` datasets are made, fewer where it is soon plain that chance does as well
    (the sequential test of Besag and Clifford 1991, whose p-values stay valid). Equal seeds give
    equal results for any number of workers.
    """
    tested = tested_model(posterior, u, spreads, candidates, records_alone=False)
    looked: list[DatasetGains] = []
    found = None
    while found is None or (found.n_worlds < n_worlds and not _enough(found, n_worlds)):
        # The records come before the first simulated dataset.
        first = len(looked) - 1
        at_once = AT_ONCE if looked and not tested.gains.alternatives.all_held else 1
        numbers = range(first, min(max(first, 0) + at_once * BATCH, n_worlds))
        looked += gains_by_chance(tested, seed, numbers, progress, n_worlds)
        for n in [*range(max(first, 0) + BATCH, numbers.stop, BATCH), numbers.stop]:
            found = _judged(tested, candidates, expected, looked[: n + 1])
            if _enough(found, n_worlds):
                break
    return found


def tested_model(
    posterior: Posterior,
    u: Floats,
    spreads: GroupSpreads,
    candidates: Sequence[Definition],
    records_alone: bool,
) -> TestedModel:
    """The model's tables and design, and the alternatives of each candidate.

    Where the `records_alone` are to be looked at, and no simulated datasets, blocks that candidates
    move are run near these only.
    """
    observations, layout = posterior.observations, posterior.layout
    near = records_alone and not sight_is_limited(observations, posterior.effects)
    track_scatter = 0.0 if layout.track_scatter is None else float(np.exp(u[layout.track_scatter]))
    values, curvature = layout.effect_values(u), float(posterior.specification.centrifugal)
    runs = run_blocks(observations, posterior.effects, values, curvature)
    predicted = predict_records(observations, posterior.effects, values, curvature, runs)
    design = base_design(posterior, u, spreads.plan, spreads.scale)
    coefficients = base_coordinates(posterior, u)
    about = design.constant + design.x @ coefficients
    base = make_tables(observations, predicted, observations.limit, track_scatter, about)
    model = ModelAtMode(posterior, u, base, design, coefficients, track_scatter, runs, near)
    tried = [each for entry in candidates for each in alternatives_of(entry, model)]
    keys = [c.key for c in candidates]
    precomputed = [a for each in tried if isinstance(each, list) for a in each]
    columns = effect_columns(base, design, precomputed, {key: k for k, key in enumerate(keys)})
    gains = Gains(
        base,
        design,
        HeldAlternatives(tried),
        keys,
        coefficients,
        float(u[layout.scatter]),
        spreads.tau,
        posterior.specification.tails == "student",
        observations,
        columns,
        any(entry.says_what_is_seen for entry in candidates),
    )
    without = tuple(
        base_design(posterior, u, spreads.plan.without((key,)), np.delete(spreads.scale, g))
        for g, key in enumerate(spreads.plan.keys)
    )
    firsts = range(0, len(predicted.curve.x), CURVES)
    broken = np.concatenate([predicted.curve[k : k + CURVES].broken for k in firsts])
    square = tuple(map(squares, predicted.speeds))
    return TestedModel(
        posterior, u, spreads, track_scatter, predicted, broken, square, gains, without
    )


def gains_by_chance(
    tested: TestedModel,
    seed: int,
    numbers: range,
    progress: Callable[[float], None],
    n_worlds: int,
) -> list[DatasetGains]:
    """Gains on datasets in which the model is true, each by its own seed; -1 are the records."""
    if chosen().name == LOCAL:
        return _gains_on((tested, seed), numbers, lambda s: progress(_share(numbers, s, n_worlds)))
    # Each worker goes through the candidates with the datasets that it has.
    parts = [numbers[k : k + PART] for k in range(0, len(numbers), PART)]
    looked: list[DatasetGains] = []
    for k, part in enumerate(spread_map(_gains_on, (tested, seed), parts)):
        looked += part
        progress(_share(numbers, (k + 1) / len(parts), n_worlds))
    return looked


def _share(numbers: range, share: float, n_worlds: int) -> float:
    """How much is done with this share of these datasets."""
    done = max(numbers.start, 0)
    return (done + share * (numbers.stop - done)) / n_worlds


def _gains_on(
    shared: tuple[TestedModel, int],
    numbers: range,
    progress: Callable[[float], None] = lambda _share: None,
) -> list[DatasetGains]:
    tested, seed = shared
    datasets = list(ordered_map(partial(_dataset, tested, seed), numbers))
    records, references, beside = zip(*datasets, strict=True)
    of_candidates = tested.gains.of_candidates(records, references, progress)
    return [DatasetGains(g, *more) for g, more in zip(of_candidates, beside, strict=True)]


def _dataset(
    tested: TestedModel, seed: int, number: int
) -> tuple[BootstrapRecords, Reference, tuple[Floats, Paired | None, float]]:
    """One simulated dataset, or the records themselves (-1), and all but the candidates' gains."""
    gains = tested.gains
    if number >= 0:
        records, alike = _simulated(tested, generator(seed, "screening", number))
    else:
        records = actual_records(tested.posterior)
        alike = [records] * len(tested.without)
    of_groupings = [
        gains.of_grouping(g, own, without)
        for g, (own, without) in enumerate(zip(alike, tested.without, strict=True))
    ]
    reference = gains.reference(records)
    pair = gains.of_pair(records, reference)
    limit = gains.of_limit_by_chance(records, reference) if gains.asks_detection else 0.0
    return records, reference, (np.array(of_groupings, np.float64), pair, limit)


def _simulated(
    tested: TestedModel, rng: np.random.Generator
) -> tuple[BootstrapRecords, list[BootstrapRecords]]:
    """Records where the model is true, and for each grouping such in which its groups are alike.

    What its groups had shared is then scatter of the events by themselves, or such datasets would
    vary less than the records do.
    """
    spreads, layout = tested.spreads, tested.posterior.layout

    def simulated(tau: Floats, u: Floats) -> BootstrapRecords:
        return simulate(
            tested.posterior,
            tested.predicted,
            u,
            spreads.plan,
            tau,
            tested.track_scatter,
            rng,
            tested.broken,
            tested.square,
        )

    tau = spreads.drawn(rng)
    records, alike = simulated(tau, tested.u), []
    for g, spread in enumerate(spreads.tau):
        u = tested.u.copy()
        if layout.log_scatter:
            u[layout.scatter] = 0.5 * np.log(np.exp(2.0 * u[layout.scatter]) + spread**2)
        alike.append(simulated(np.where(np.arange(len(tau)) == g, 0.0, tau), u))
    return records, alike


def _judged(
    tested: TestedModel,
    candidates: Sequence[Definition],
    expected: Sequence[str],
    looked: Sequence[DatasetGains],
) -> Screening:
    """The gains on the records, which come first, beside those on the datasets simulated so far."""
    plan = tested.spreads.plan
    levels = map(group_level, plan.lasting)
    found = judge(
        candidates,
        np.array([each.of_candidates for each in looked]),
        np.array([each.limit for each in looked]),
        list(zip(plan.keys, levels, strict=True)),
        np.array([each.of_groupings for each in looked]),
        expected,
    )
    pair = looked[0].pair
    if pair is None:
        return found
    # The most surprising pair beside those of the simulated datasets.
    null = np.array([0.0 if each.pair is None else each.pair.surprise for each in looked[1:]])
    p = (1.0 + float(np.sum(null >= pair.surprise))) / (len(null) + 1.0)
    keys = candidates[pair.first].key, candidates[pair.second].key
    return replace(found, pair=PairTest(keys, pair.surprise, p))


def _enough(found: Screening, n_worlds: int) -> bool:
    """Whether chance plainly does as well.

    Twice as many simulated datasets have exceeded the records as could in all of them if these were
    to be significant.
    """
    best = min((c.p_family for c in found.candidates), default=1.0)
    levels = [(best, LEVEL), *((group.p_value, group.level) for group in found.groups)]
    if found.pair is not None:
        levels.append((found.pair.p_value, PAIR_LEVEL))
    return all(p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1) for p, level in levels)


def gains_beside(
    posterior: Posterior, u: Floats, spreads: GroupSpreads, candidates: Sequence[Definition]
) -> dict[str, float]:
    """What each candidate gains (nats) on the records beside all that a model at its mode has.

    Arguments as in `screen`.
    """
    tested = tested_model(posterior, u, spreads, candidates, records_alone=True)
    records = actual_records(posterior)
    (gains,) = tested.gains.of_candidates([records], [tested.gains.reference(records)])
    return {c.key: float(gain) for c, gain in zip(candidates, gains, strict=True)}
