"""What candidates gain on the records, and on worlds in which the model is true."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.gains import Reference
from avahazard.criticism.screening.masked_pairs import Paired
from avahazard.criticism.screening.parametric_bootstrap import (
    BootstrapRecords,
    make_world,
    real_world,
)
from avahazard.criticism.screening.tested_model import TestedModel
from avahazard.engine import LOCAL, chosen, spread_map
from avahazard.inference.seeds import generator
from avahazard.workers import ordered_map

PART = 10
"""Worlds that are given to a worker of another process at once."""


class Beside(NamedTuple):
    """What groupings `[n_groupings]`, and the best pair of candidates, gain on one world.

    `limit` is what limits of sight gain there where nothing is fitted anew (`limit_by_chance`).
    """

    of_groupings: Floats
    pair: Paired | None
    limit: float


class _World(NamedTuple):
    """One made world, and all but the candidates' own gains on it."""

    records: BootstrapRecords
    reference: Reference
    beside: Beside


class WorldGains(NamedTuple):
    """What candidates `[n_candidates]`, and all else that is asked, gain on one world."""

    of_candidates: Floats
    beside: Beside


def gains_by_chance(
    tested: TestedModel,
    seed: int,
    numbers: range,
    progress: Callable[[float], None],
    n_worlds: int,
) -> list[WorldGains]:
    """Gains on worlds in which the model is true, each by its own seed; -1 are the records."""
    if chosen().name == LOCAL:
        return _gains_on((tested, seed), numbers, lambda s: progress(_share(numbers, s, n_worlds)))
    # Each worker goes through the candidates with the worlds that it has.
    parts = [numbers[k : k + PART] for k in range(0, len(numbers), PART)]
    looked: list[WorldGains] = []
    for k, part in enumerate(spread_map(_gains_on, (tested, seed), parts)):
        looked += part
        progress(_share(numbers, (k + 1) / len(parts), n_worlds))
    return looked


def _share(numbers: range, share: float, n_worlds: int) -> float:
    """How much is done with this share of these worlds."""
    done = max(numbers.start, 0)
    return (done + share * (numbers.stop - done)) / n_worlds


def _gains_on(
    shared: tuple[TestedModel, int],
    numbers: range,
    progress: Callable[[float], None] = lambda _share: None,
) -> list[WorldGains]:
    tested, seed = shared
    worlds = list(ordered_map(partial(_world, tested, seed), numbers))
    gains = tested.gains.of_candidates(
        [world.records for world in worlds], [world.reference for world in worlds], progress
    )
    return [WorldGains(g, world.beside) for g, world in zip(gains, worlds, strict=True)]


def _world(tested: TestedModel, seed: int, number: int) -> _World:
    """One made world, or the records themselves (-1)."""
    if number >= 0:
        return _made_world(tested, seed, number)
    records = real_world(tested.posterior)
    alike = [records] * len(tested.spreads.tau)
    return _looked_at(tested, records, alike)


def _made_world(tested: TestedModel, seed: int, world: int) -> _World:
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
            tested.track_scatter,
            rng,
            tested.broken,
            tested.square,
        )

    tau = spreads.drawn(rng)
    records = made(tau, tested.u)
    alike = [
        made(np.where(np.arange(len(tau)) == g, 0.0, tau), _with_scatter(tested, spreads.tau[g]))
        for g in range(len(tau))
    ]
    return _looked_at(tested, records, alike)


def _with_scatter(tested: TestedModel, tau: float) -> Floats:
    """The coordinates with the spread `tau` of groups put into the scatter of the events."""
    layout = tested.posterior.layout
    u = tested.u.copy()
    if layout.log_scatter:
        u[layout.scatter] = 0.5 * np.log(np.exp(2.0 * u[layout.scatter]) + tau**2)
    return u


def _looked_at(
    tested: TestedModel, records: BootstrapRecords, records_of_groupings: Sequence[BootstrapRecords]
) -> _World:
    """Gains of each grouping on records of its own, and of the best pair of candidates."""
    of_groupings = [
        tested.gains.of_grouping(g, own, without)
        for g, (own, without) in enumerate(zip(records_of_groupings, tested.without, strict=True))
    ]
    reference = tested.gains.reference(records)
    pair = tested.gains.of_pair(records, reference)
    limit = tested.gains.of_limit_by_chance(records, reference) if tested.gains.asks_sight else 0.0
    return _World(records, reference, Beside(np.array(of_groupings, np.float64), pair, limit))
