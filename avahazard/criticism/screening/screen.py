"""Which candidate effects the data ask for, against what chance alone would show.

All are tried on the linear model at once. A gain is turned into a p-value of its own, and the
smallest of these into a family-wise one by simulated rows in which nothing is missing (Westfall and
Young 1993). What a full fit gains is held against the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, product
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import least_squares
from scipy.special import gammaincc

from avahazard.arrays import Floats, Ints
from avahazard.criticism.screening.linear_model import NOTHING, LinearModel, linear_model
from avahazard.effects.catalogue import catalogue
from avahazard.effects.change import ALL, SEVERAL, YEARS, change
from avahazard.effects.columns import FALL_HEIGHT, NORTH, ORIENTATION
from avahazard.effects.covariate import (
    PATH_ID,
    RELEASE,
    VOLUME,
    covariate,
    line_of,
    ratios_to_volume,
    scatter_by,
)
from avahazard.effects.effect import Definition, Effect, FrictionEffect
from avahazard.effects.pairs import interaction
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import volume_share
from avahazard.inference.model.laws import LAWS, Law
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator
from avahazard.results.diagnosis import LEVEL
from avahazard.workers import ordered_map

EXPECTED_SHARE = 2.0 / 3.0
"""Share of that level for candidates that were expected before anybody looked."""
PAIR_LEVEL = 0.005
"""Level of pairs of which neither shows alone."""
MOST_PAIRS = 300
"""Pairs that are tried: those that go together most where there are more."""
LOG_2 = float(np.log(2.0))


@dataclass(frozen=True, slots=True)
class Screened:
    """A candidate after the screening.

    Its gain (nats) to first order, and the `shape` and `scale` of the gamma distribution that it
    has by chance, in half of all cases where it can only be of one sign (`one_sided`). `surprise`
    is -log p of it by itself, less its `price` (`Block`); `p_family` family-wise. `likely`
    `[n_parameters]` are values of its parameters, to first order (none for what is no effect).
    """

    definition: Definition
    gain: float
    shape: float
    scale: float
    one_sided: bool
    surprise: float
    p_family: float
    likely: Floats
    price: float = 0.0

    @property
    def key(self) -> str:
        """The effect's key."""
        return self.definition.key

    @property
    def p_single(self) -> float:
        """p-value by itself."""
        return float(np.exp(-self.surprise))

    @property
    def null_gain(self) -> float:
        """Gain that chance exceeds in one of twenty cases."""
        return self.gain_at(float(-np.log(0.05)))

    def gain_at(self, surprise: float) -> float:
        """Gain that has this surprise by itself."""
        share = min(np.exp(LOG_2 * self.one_sided - self.price - surprise), 1.0)
        return float(stats.gamma.isf(share, self.shape, scale=self.scale))

    def surprise_of(self, gain: float) -> float:
        """-log p of a gain by itself."""
        by_chance = self.shape, self.scale, self.one_sided, self.price
        return float(_surprise(np.array([gain]), *by_chance)[0])


@dataclass(frozen=True, slots=True)
class PairTest:
    """The most surprising of pairs that gain together what neither does alone.

    Its p-value is against that of each simulated dataset.
    """

    keys: tuple[str, str]
    p_value: float


@dataclass(frozen=True, slots=True, eq=False)
class Screening:
    """All candidates, the most surprising first, and what chance does.

    `largest` `[n_worlds]` is the largest surprise of each simulated dataset.
    """

    candidates: tuple[Screened, ...]
    largest: Floats
    pair: PairTest | None

    @property
    def critical_surprise(self) -> float:
        """Surprise that some candidate exceeds in a share `LEVEL` of datasets."""
        return float(np.quantile(self.largest, 1.0 - LEVEL))

    @property
    def critical_gain(self) -> float:
        """Gain of one parameter that has it."""
        return 0.5 * float(stats.chi2.isf(np.exp(-self.critical_surprise), 1))

    def p_family(self, surprise: float, share: float = 1.0) -> float:
        """Family-wise p-value of a surprise, over the share of the level that it is held to."""
        n = len(self.largest) + 1.0
        return float(min((1.0 + np.sum(self.largest >= surprise)) / n / share, 1.0))


def screen(
    posterior: Posterior,
    u: Floats,
    candidates: Sequence[Definition],
    n_worlds: int = 999,
    seed: int = 0,
) -> Screening:
    """Screen the candidates on a model at its mode u, groups of events included."""
    model = linear_model(posterior, u)
    tried = blocks(candidates, model)
    by_key = {entry.key: entry for entry in candidates}
    if not tried:
        return Screening((), np.zeros(n_worlds), None)
    columns = np.hstack([b.columns for b in tried])
    weighed = model.projected(columns)
    scores = weighed.T @ np.column_stack(
        [model.residual, model.by_chance(n_worlds, generator(seed, "screening"))]
    )
    ends = np.cumsum([b.columns.shape[1] for b in tried])
    places = [np.arange(end - b.columns.shape[1], end) for end, b in zip(ends, tried, strict=True)]
    found: dict[str, Screened] = {}
    largest = np.zeros(n_worlds + 1)

    def tested(block: Block, at: Ints) -> tuple[Screened, Floats]:
        bend = weighed[:, at].T @ columns[:, at]
        gains, shape, scale, change = _gains(scores[at], bend, block)
        one_sided, price = block.side != 0, block.price
        surprise = _surprise(gains, shape, scale, one_sided, price)
        likely = block.values.copy()
        likely[: len(change)] += change[: len(likely)]
        by_itself = float(gains[0]), shape, scale, one_sided, float(surprise[0])
        return Screened(by_key[block.key], *by_itself, 1.0, likely, price), surprise

    for candidate, surprise in ordered_map(tested, tried, places):
        largest = np.maximum(largest, surprise)
        key = candidate.key
        if key not in found or candidate.surprise > found[key].surprise:
            found[key] = candidate
    pairs = [
        k
        for k, b in enumerate(tried)
        if b.on_friction and by_key[b.key].beyond < 2 and by_key[b.key].alternatives is None
    ]
    pair = _pair([tried[k] for k in pairs], [places[k] for k in pairs], scores, weighed, columns)
    chance = Screening((), largest[1:], pair)
    ranked = sorted(found.values(), key=lambda c: -c.surprise)
    ranked = [replace(c, p_family=chance.p_family(c.surprise)) for c in ranked]
    return replace(chance, candidates=tuple(ranked))


def _gains(scores: Floats, bend: Floats, block: Block) -> tuple[Floats, float, float, Floats]:
    """Gains `[1 + n_worlds]` of one block, shape and scale by chance, change of its parameters."""
    inverse = np.linalg.inv(bend + np.diag(block.precision))
    gains = 0.5 * np.einsum("in,ij,jn->n", scores, inverse, scores)
    if block.side:
        gains = np.where(block.side * scores[0] > 0.0, gains, 0.0)
    weights = np.maximum(np.linalg.eigvals(bend @ inverse).real, 1e-12)
    mean, variance = 0.5 * float(np.sum(weights)), 0.5 * float(np.sum(weights**2))
    return gains, mean**2 / variance, variance / mean, inverse @ scores[:, 0]


def _surprise(
    gains: Floats, shape: float, scale: float, one_sided: bool, price: float = 0.0
) -> Floats:
    """-log p of gains by themselves, less the price; 0 for none."""
    with np.errstate(divide="ignore"):
        tail = -np.log(gammaincc(shape, np.maximum(gains, 0.0) / scale))
    tail = np.maximum(tail + LOG_2 * one_sided - price, 0.0)
    return np.where(gains > 0.0, tail, 0.0)


ALIKE_DIGITS = 9
"""Digits to which pairs are compared: beyond them two that are one column differ by rounding."""


def _pair(
    tried: Sequence[Block], places: Sequence[Ints], scores: Floats, weighed: Floats, columns: Floats
) -> PairTest | None:
    """The pair of effects on friction that gains most over the better of its two.

    Gains over one alone are as χ² with the freedom of both effects, at most.
    """
    if len(tried) < 2:
        return None

    def gains(at: Ints, precision: Floats) -> Floats:
        bend = weighed[:, at].T @ columns[:, at] + np.diag(precision)
        return np.asarray(0.5 * np.sum(scores[at] * np.linalg.solve(bend, scores[at]), axis=0))

    def alike(a: int, b: int) -> float:
        cross = weighed[:, places[a]].T @ columns[:, places[b]]
        own = [np.sum(weighed[:, places[k]] * columns[:, places[k]], axis=0) for k in (a, b)]
        return float(np.max(np.abs(cross) / np.sqrt(np.maximum(np.outer(*own), 1e-300))))

    alone = [gains(at, b.precision) for b, at in zip(tried, places, strict=True)]
    best, which = np.full(scores.shape[1], -1.0), (0, 0)
    # What is tried must not depend on what the records gain, or chance would have less to choose.
    # Of two that are one column the first is taken, whatever is rounded.
    pairs = combinations(range(len(tried)), 2)
    together = sorted(pairs, key=lambda pair: -round(alike(*pair), ALIKE_DIGITS))
    for a, b in together[:MOST_PAIRS]:
        at = np.concatenate([places[a], places[b]])
        precision = np.concatenate([tried[a].precision, tried[b].precision])
        more = np.maximum(gains(at, precision) - np.maximum(alone[a], alone[b]), 0.0)
        surprise = -np.log(np.maximum(gammaincc(0.5 * len(at), more), 1e-300))
        which = (a, b) if surprise[0] > best[0] + 10.0**-ALIKE_DIGITS else which
        best = np.maximum(best, surprise)
    p = float(1.0 + np.sum(best[1:] >= best[0])) / len(best)
    return PairTest((tried[which[0]].key, tried[which[1]].key), p)


COMMON_COLUMNS = ("year", "deposit_length_m", RELEASE, VOLUME)
"""Columns that are not covariates of a file but may drive friction."""
WHEN_AND_WHERE = ("day_of_winter", RELEASE)
"""What every record has of the snow's state."""
PAIRED = (*WHEN_AND_WHERE, VOLUME, PATH_ID)
"""What every record has that may decide whether a column matters: warmth does below a snow line,
wind on lee slopes."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and what is made of the file's columns."""
    known, columns = catalogue().values(), observations.columns
    # Where a path faces is asked by northness and eastness.
    texts = [name for name in columns.texts if name != ORIENTATION]
    known_columns = (*columns.numbers, *texts, *columns.made)
    of_events = [name for name in known_columns if name != FALL_HEIGHT]
    # A smooth of a column that has an effect of its own would only repeat it.
    taken = {entry.column for entry in known}
    ratios = [name for name in ratios_to_volume(columns) if not name.endswith(FALL_HEIGHT)]
    smooth_in = dict.fromkeys([*of_events, *COMMON_COLUMNS, *ratios])
    smooths = [covariate(c) for c in smooth_in if c not in taken]
    # A direction in degrees begins anew at north: beside another column it is two parts.
    paired = [name for name in of_events if name + NORTH not in columns.numbers]
    pairs = [f"{one}*{other}" for one, other in combinations([*paired, *PAIRED], 2)]
    made = [
        *map(interaction, pairs),
        *map(scatter_by, [*of_events, *WHEN_AND_WHERE, "year"]),
        *map(change, [*columns.paths, SEVERAL, ALL, YEARS]),
    ]
    data = columns, observations.sites
    return [
        entry
        for entry in (*own, *known, *smooths, *made)
        if entry.nuisance is None
        and not specification.has(entry)
        and not entry.already_stated(*data)
        and entry.lacking(*data) is None
    ]


def not_asked(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> dict[str, str]:
    """Effects whose column the records have, though not enough of it, and what it lacks."""
    data = observations.columns, observations.sites
    columns = {*observations.columns.numbers, *observations.columns.texts}
    if any(site.profile.land_cover for site in observations.sites):
        columns.add("land_cover")
    lacks = {
        entry.key: entry.lacking(*data)
        for entry in (*own, *catalogue().values())
        if columns & {entry.column, entry.needs} and not specification.has(entry)
    }
    return {key: lack for key, lack in lacks.items() if lack is not None}


MOST_STEPS = 40
SHAPES = 0.05
"""Change by a parameter that only shapes the first one, against the change by that, at most."""
OTHER_POINTS = 4
"""Values tried of each parameter that only shapes what the first one is the strength of."""


class Block(NamedTuple):
    """Columns `[n_rows, n]` of one candidate by key, of prior `precision` `[n]`.

    They are the changes by the first of its parameters, which stand at `values`.
    `side` is 1 or -1 where its one coefficient can only be above or below 0; `on_friction`: it is
    a column of log friction and nothing else. `price` (nats) is that of one of many of a kind, and
    of one of many regions of two columns, which all together weigh as one candidate.
    """

    key: str
    columns: Floats
    precision: Floats
    values: Floats
    side: int = 0
    on_friction: bool = False
    price: float = 0.0


def blocks(candidates: Sequence[Definition], model: LinearModel) -> list[Block]:
    """All candidates' columns; several blocks where something only shapes the effect."""

    def of(entry: Definition) -> list[Block]:
        price = price_of_family(entry, candidates)
        return [b._replace(price=b.price + price) for b in _blocks(entry, model)]

    found = ordered_map(of, candidates)
    return [b for b in chain.from_iterable(found) if np.any(b.columns)]


def price_of_family(entry: Definition, candidates: Sequence[Definition]) -> float:
    """Price (nats) of a cause that is one of many of a kind, which weigh as one together."""
    if not (entry.beyond and entry.names_cause):
        return 0.0
    return float(np.log(sum(other.family == entry.family for other in candidates)))


def _blocks(entry: Definition, model: LinearModel) -> Iterator[Block]:
    posterior = model.posterior
    columns, sites = posterior.observations.columns, posterior.observations.sites
    if entry.level_alone is not None:
        return
    if entry.changes is None:
        ways = (entry.alternatives or (lambda *data: [entry.facts(*data)]))(columns, sites)
        for facts in ways:
            price = float(np.log(len(ways))) if "region" in facts else 0.0
            for block in _of_effect(entry.build(facts), model):
                yield block._replace(price=price)
    elif entry.changes.field == "law":
        for other in LAWS.values():
            if other.name != posterior.specification.law and other.uses_volume:
                rows = model.on_friction(_other_law(other, model)[:, None])
                yield Block(entry.key, rows, np.ones(1), NOTHING)
        yield from _smooth_law(entry.key, model)
    elif entry.changes.field == "scatter":
        volume = np.exp(posterior.volumes(model.u).mean)
        share = volume_share(volume, float(np.quantile(volume, 0.9)))
        yield Block(entry.key, model.on_natural_scatter(-share[:, None]), np.ones(1), NOTHING)
    else:
        wider = posterior.specification.put(entry.changes, entry.changes.value)
        before = model.moved(model.beside())
        after = model.moved(model.beside(specification=wider))
        rows = model.with_rest(model.by_motion(before, after), before, after)
        yield Block(entry.key, rows[:, None], np.ones(1), NOTHING, 1)


def _other_law(other: Law, model: LinearModel) -> Floats:
    """What another law, fitted to this one by least squares, has beside it `[n_events]`."""
    posterior = model.posterior
    volume = np.exp(posterior.volumes(model.u).mean)
    selected = posterior.layout.law
    ours = selected.log_friction(model.u[: len(selected.coordinates)], volume)
    start = other.start(volume, np.exp(ours))
    scale = np.maximum(np.abs(start), 0.1)

    def apart(v: Floats) -> Floats:
        return np.asarray(other.log_friction(v * scale, volume) - ours)

    fitted = least_squares(apart, start / scale, max_nfev=MOST_STEPS)
    return apart(fitted.x)


def _smooth_law(key: str, model: LinearModel) -> Iterator[Block]:
    """Any curve over the volume: what is far from this law no other one shows near it."""
    observations = model.posterior.observations
    there = replace(observations.columns, log_volume=model.posterior.volumes(model.u).mean)
    if line_of(there, VOLUME) is None:
        return
    smooth = covariate(VOLUME)
    effect = smooth.build(smooth.facts(there, observations.sites))
    assert isinstance(effect, FrictionEffect)
    precision = np.array([p.prior_sd**-2.0 for p in effect.parameters])
    yield Block(key, model.on_friction(effect.design(there)), precision, NOTHING)


def _of_effect(effect: Effect, model: LinearModel) -> Iterator[Block]:
    first, *others = effect.parameters
    side = int(first.low == first.neutral) - int(first.high == first.neutral)
    precision = np.array([p.prior_sd**-2.0 for p in effect.parameters])
    on_friction = isinstance(effect, FrictionEffect)
    neutral = effect.neutral
    whole = model.of_effect(effect, neutral)
    # Parameters after the first may act without it: `whole` is the change at nearly none of it.
    size = np.max(np.abs(whole), axis=0) * [p.prior_sd for p in effect.parameters]
    if not others or np.max(size[1:]) > SHAPES * size[0]:
        yield Block(effect.key, whole, precision, neutral, 0 if others else side, on_friction)
        return
    for corner in product(*(np.linspace(p.low, p.high, OTHER_POINTS) for p in others)):
        values = np.array([first.neutral, *corner])
        yield Block(
            effect.key, model.of_effect(effect, values, of_first=True), precision[:1], values, side
        )
