"""Which effects could be missing, each as the alternatives to the model that are screened.

Their tables and designs do not change between simulated datasets.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.designs import (
    law_design,
    scatter_slope_designs,
    volume_error_designs,
    with_columns,
)
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.tables import Tables, model_tables, with_scatter
from avahazard.effects.catalogue import catalogue
from avahazard.effects.covariate import covariate
from avahazard.effects.effect import (
    Definition,
    Effect,
    FrictionEffect,
    LimitEffect,
    MotionEffect,
    Parameter,
    VolumeErrorEffect,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import BlockRuns
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

COMMON_COLUMNS = ("year", "deposit_length_m")
"""Columns that are not covariates of a file but may drive friction."""
APART, FEWEST_VALUES, MOST_VALUES = 2.5, 5, 9
"""How many times as far from neutral each value of a first parameter is as the one before, and how
many are tried on each side."""
OTHER_POINTS, SLOW_OTHER_POINTS = 4, 3
"""Values tried of each other one; the second where friction depends on speed, whose runs cost ten
times as much."""
LIMITS = 6
"""Detection limits that are tried."""
STEP = 1e-3
"""Step of the differences for scores, in prior standard deviations."""
SPEED_SHARES = (1.0, 0.4)
"""Shares of the model's present error of speed that are tried with an effect: it may fall."""
MOST_BYTES = 256_000_000
"""Memory of tables that are kept from one look at the candidates to the next."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and a smooth of every column."""
    known = catalogue().values()
    columns = [*observations.columns.numbers, *observations.columns.texts, *COMMON_COLUMNS]
    # A smooth of a column that has an effect of its own would only repeat it.
    smooths = [covariate(c) for c in dict.fromkeys(columns) if c not in {e.column for e in known}]
    data = observations.columns, observations.sites
    return [
        entry
        for entry in (*own, *known, *smooths)
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


@dataclass(frozen=True, slots=True, eq=False)
class Alternative:
    """One value of a candidate: its key, tables, design, and log prior against neutral.

    `margin` (m): stops this far above the highest one of their path are not recorded; the limit
    moves with each dataset's own stops. `other_law`: the coefficients are those of another law.
    """

    key: str
    tables: Tables
    design: Design
    log_prior: float
    margin: float | None = None
    other_law: bool = False


Alternatives = list[Alternative] | Callable[[], list[Alternative]]
"""Precomputed where they share the tables of the model; else made anew at each call, and then they
share one run of every site's block."""


@dataclass(frozen=True, slots=True, eq=False)
class ModelAtMode:
    """The model that is screened, at its mode `u`, with its `tables` and `design`.

    `coefficients` of the design, `track_scatter` and `runs` of the block are those at u. Tables of
    alternatives are right `near` the records alone, or all over.
    """

    posterior: Posterior
    u: Floats
    tables: Tables
    design: Design
    coefficients: Floats
    track_scatter: float
    runs: BlockRuns
    near: bool


def alternatives_of(definition: Definition, model: ModelAtMode) -> list[Alternatives]:
    """Every value of one candidate that the screening tries.

    What needs tables of its own is made when it is asked for.
    """
    setting, key = definition.changes, definition.key
    posterior, u, base, design = model.posterior, model.u, model.tables, model.design
    if setting is None:
        observations = posterior.observations
        effect = definition.build(definition.facts(observations.columns, observations.sites))
        if isinstance(effect, FrictionEffect):
            wider = with_columns(design, effect, effect.design(observations.columns))
            return [[Alternative(key, base, wider, 0.0)]]
        if isinstance(effect, VolumeErrorEffect):
            read = volume_error_designs(effect, posterior, u, design)
            return [[Alternative(key, base, other, prior) for other, prior in read]]
        return [
            partial(_with_effect, model, effect, values, log_prior)
            for values, log_prior in _values_tried(effect, posterior, u)
        ]
    if setting.field == "law":
        mine = posterior.specification.law
        names = [name for name, item in LAWS.items() if name != mine and item.uses_volume]
        designs = [law_design(posterior, u, name, design, model.coefficients) for name in names]
        return [[Alternative(key, base, other, 0.0, other_law=True) for other in designs]]
    if setting.field == "scatter":
        slopes = scatter_slope_designs(posterior.volumes(u), design)
        return [[Alternative(key, base, other, prior) for other, prior in slopes]]
    changed = posterior.specification.put(setting, setting.value)
    return [partial(_with_setting, model, key, float(changed.centrifugal))]


def _with_setting(model: ModelAtMode, key: str, curvature: float) -> list[Alternative]:
    """The model with another setting of the block."""
    posterior = model.posterior
    tables = model_tables(
        posterior.observations,
        posterior.effects,
        posterior.layout.effect_values(model.u),
        curvature,
        posterior.observations.limit,
        model.track_scatter,
        model.tables.about,
    )
    return [Alternative(key, tables, model.design, 0.0)]


def _with_effect(
    model: ModelAtMode, effect: Effect, values: Floats, log_prior: float
) -> list[Alternative]:
    """The model with an effect on the motion or on the record, at these values."""
    posterior, observations = model.posterior, model.posterior.observations
    limit, margin = observations.limit, None
    if isinstance(effect, LimitEffect):
        limit, margin = effect.limit(observations.columns, values), float(values[0])
    effects = (*posterior.effects, effect)
    all_values = {**posterior.layout.effect_values(model.u), effect.key: values}
    shares = SPEED_SHARES if observations.speeds else (1.0,)
    whole = model_tables(
        observations,
        effects,
        all_values,
        float(posterior.specification.centrifugal),
        limit,
        model.track_scatter,
        model.tables.about,
        None if isinstance(effect, MotionEffect) else model.runs,
        model.near,
    )
    tables = [with_scatter(whole, share * model.track_scatter) for share in shares]
    return [Alternative(effect.key, each, model.design, log_prior, margin) for each in tables]


def _values_tried(effect: Effect, posterior: Posterior, u: Floats) -> list[tuple[Floats, float]]:
    """Values of the parameters that are tried, and their log prior against neutral."""
    first, *others = effect.parameters
    slow = isinstance(effect, MotionEffect) and effect.speed_dependent
    n = SLOW_OTHER_POINTS if slow else OTHER_POINTS
    between = [np.linspace(p.low, p.high, n).tolist() for p in others]
    if isinstance(effect, LimitEffect):
        values = first.plausible(LIMITS)
    else:
        values = _told_apart(first, _standard_error(effect, posterior, u))
    z, z0 = ((np.array(at) - first.prior_mean) / first.prior_sd for at in (values, first.neutral))
    log_prior = 0.5 * (z0 * z0 - z * z)
    return [
        (np.array([value, *corner]), float(prior))
        for value, prior in zip(values, log_prior, strict=True)
        for corner in product(*between)
    ]


def _told_apart(parameter: Parameter, error: float) -> list[float]:
    """Values from one standard error off neutral to the ends of the range, each `APART` times on.

    So something is tried near the likeliest value whether records tell little or, as with many
    speeds, a thousandth of the range.
    """
    values = []
    for end in (parameter.low, parameter.high):
        reach = end - parameter.neutral
        if reach != 0.0:
            steps = np.log(abs(reach) / error) / np.log(APART)
            n = int(np.clip(np.ceil(steps), FEWEST_VALUES - 1, MOST_VALUES - 1))
            values += (parameter.neutral + reach * APART ** -np.arange(n + 1.0)).tolist()
    return values


def _standard_error(effect: Effect, posterior: Posterior, u: Floats) -> float:
    """That of the first parameter about neutral: by the squares of each event's score, and prior.

    All other coordinates are held at u, so it is the least that it could be.
    """
    wider = Posterior(posterior.observations, posterior.specification, (*posterior.effects, effect))
    known = dict(zip((slot.name for slot in posterior.layout.slots), u, strict=True))
    slots = wider.layout.slots
    at = np.array([known.get(s.name, s.mean if np.isnan(s.neutral) else s.neutral) for s in slots])
    k = wider.layout.places[effect.key].start
    moved = at.copy()
    moved[k] += STEP if at[k] + STEP <= wider.layout.high[k] else -STEP
    here, there = (wider.pinned(v).event_log_likelihood(v) for v in (at, moved))
    information = float(np.sum(((there - here) / STEP) ** 2))
    return effect.parameters[0].prior_sd / float(np.sqrt(1.0 + information))


class HeldAlternatives:
    """Alternatives value by value of each candidate, in the same order at each look.

    Those with tables of their own are some 100 tables of 3 kB for each event: what finds no room
    is made anew at each look, and dropped before the next one.
    """

    def __init__(self, alternatives: Sequence[Alternatives], most_bytes: int = MOST_BYTES) -> None:
        self._alternatives = list(alternatives)
        self._room = most_bytes

    def __len__(self) -> int:
        return len(self._alternatives)

    def __iter__(self) -> Iterator[list[Alternative]]:
        for k, each in enumerate(self._alternatives):
            yield each if isinstance(each, list) else self._kept(k, each())

    @property
    def all_held(self) -> bool:
        """Whether another look costs no tables; known after the first."""
        return all(isinstance(each, list) for each in self._alternatives)

    def _kept(self, k: int, made: list[Alternative]) -> list[Alternative]:
        own = {id(a.tables.record): a.tables for a in made}
        size = sum(map(_bytes, own.values()))
        if size <= self._room:
            self._room -= size
            self._alternatives[k] = made
        return made


def _bytes(tables: Tables) -> int:
    """Memory of what a set of tables has of every event."""
    parts = (*tables.edges, *tables.speeds, tables.record, tables.bounds, tables.last_left)
    return sum(part.nbytes for part in parts if isinstance(part, np.ndarray))
