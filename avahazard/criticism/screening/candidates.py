"""Which effects could be missing, and what each would change, as columns of the linear model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from avahazard.arrays import Floats
from avahazard.criticism.screening.linear_model import NOTHING, LinearModel
from avahazard.effects.catalogue import catalogue
from avahazard.effects.covariate import ALL, VOLUME, change, covariate, interaction, scatter_by
from avahazard.effects.effect import Definition, Effect, FrictionEffect
from avahazard.inference.model.friction_scatter import volume_share
from avahazard.inference.model.laws import LAWS, Law
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

COMMON_COLUMNS = ("year", "deposit_length_m")
"""Columns that are not covariates of a file but may drive friction."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and what is made of the file's columns."""
    known, columns = catalogue().values(), observations.columns
    of_events = [*columns.numbers, *columns.texts, *columns.made]
    # A smooth of a column that has an effect of its own would only repeat it.
    taken = {entry.column for entry in known}
    smooths = [covariate(c) for c in dict.fromkeys([*of_events, *COMMON_COLUMNS]) if c not in taken]
    pairs = [f"{one}*{other}" for one, other in combinations([*of_events, VOLUME], 2)]
    made = [
        *map(interaction, pairs),
        *map(scatter_by, of_events),
        *map(change, [*columns.paths, ALL]),
    ]
    data = columns, observations.sites
    return [
        entry
        for entry in (*own, *known, *smooths, *made)
        if entry.nuisance is None
        and not specification.has(entry)
        and not entry.settled(*data)
        and entry.lacking(*data) is None
    ]


def not_asked(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> dict[str, str]:
    """Effects whose column the records have, though not enough of it, and what it lacks."""
    data = observations.columns, observations.sites
    columns = {*observations.columns.numbers, *observations.columns.texts}
    lacks = {
        entry.key: entry.lacking(*data)
        for entry in (*own, *catalogue().values())
        if entry.column in columns and not specification.has(entry)
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
    a column of log friction and nothing else.
    """

    key: str
    columns: Floats
    precision: Floats
    values: Floats
    side: int = 0
    on_friction: bool = False


def blocks(candidates: Sequence[Definition], model: LinearModel) -> list[Block]:
    """All candidates' columns; several blocks where something only shapes the effect."""
    found = [block for entry in candidates for block in _blocks(entry, model)]
    return [b for b in found if np.any(b.columns)]


def _blocks(entry: Definition, model: LinearModel) -> Iterator[Block]:
    posterior = model.posterior
    columns, sites = posterior.observations.columns, posterior.observations.sites
    if entry.level_alone is not None:
        return
    if entry.changes is None:
        tried = entry.alternatives or (lambda *data: [entry.facts(*data)])
        for facts in tried(columns, sites):
            yield from _of_effect(entry.build(facts), model)
    elif entry.changes.field == "law":
        for other in LAWS.values():
            if other.name != posterior.specification.law and other.uses_volume:
                rows = model.on_friction(_other_law(other, model)[:, None])
                yield Block(entry.key, rows, np.ones(1), NOTHING)
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
    mine = posterior.layout.law
    ours = mine.log_friction(model.u[: len(mine.coordinates)], volume)
    start = other.start(volume, np.exp(ours))
    scale = np.maximum(np.abs(start), 0.1)

    def apart(v: Floats) -> Floats:
        return np.asarray(other.log_friction(v * scale, volume) - ours)

    fitted = least_squares(apart, start / scale, max_nfev=MOST_STEPS)
    return apart(fitted.x)


def _of_effect(effect: Effect, model: LinearModel) -> Iterator[Block]:
    first, *others = effect.parameters
    side = int(first.low == first.neutral) - int(first.high == first.neutral)
    precision = np.array([p.prior_sd**-2.0 for p in effect.parameters])
    on_friction = isinstance(effect, FrictionEffect)
    neutral = effect.neutral
    whole = model.of_effect(effect, neutral)
    if not others or _acts_alone(effect, whole):
        yield Block(effect.key, whole, precision, neutral, 0 if others else side, on_friction)
        return
    for corner in product(*(np.linspace(p.low, p.high, OTHER_POINTS) for p in others)):
        values = np.array([first.neutral, *corner])
        yield Block(
            effect.key, model.of_effect(effect, values, of_first=True), precision[:1], values, side
        )


def _acts_alone(effect: Effect, rows: Floats) -> bool:
    """Whether parameters after the first act without it; one that shapes the first does not.

    `rows` `[n_rows, n_parameters]` are the changes by each, at nearly nothing of the first.
    """
    size = np.max(np.abs(rows), axis=0) * [p.prior_sd for p in effect.parameters]
    return bool(np.max(size[1:]) > SHAPES * size[0])
