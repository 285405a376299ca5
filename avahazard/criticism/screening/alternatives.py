"""Candidate effects spelled out for the screening.

Their tables and designs do not change between made worlds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.model_tables import model_tables
from avahazard.criticism.screening.other_designs import (
    law_design,
    scatter_slope_designs,
    volume_error_designs,
    with_columns,
)
from avahazard.criticism.screening.tables import Tables, with_scatter
from avahazard.effects.effect import (
    Definition,
    Effect,
    FrictionEffect,
    LimitEffect,
    MotionEffect,
    Parameter,
    VolumeErrorEffect,
)
from avahazard.inference.likelihood.block_runs import BlockRuns
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.specification import Specification

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


@dataclass(frozen=True, slots=True, eq=False)
class Alternative:
    """One value of a candidate: its key, tables, design, and log prior against neutral.

    `margin` (m): stops this far above the highest one of their path are not seen; the limit
    moves with each world's own stops. `other_law`: the coefficients are those of another law.
    """

    key: str
    tables: Tables
    design: Design
    log_prior: float
    margin: float | None = None
    other_law: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class AtHand:
    """Alternatives that share the tables of the model: they cost nothing to keep."""

    alternatives: list[Alternative]

    def __call__(self) -> list[Alternative]:
        """The alternatives."""
        return self.alternatives


Spelled = AtHand | Callable[[], list[Alternative]]
"""Gives alternatives that share one run of every site's block, made anew at each call."""


def alternatives_of(
    definition: Definition,
    posterior: Posterior,
    u: Floats,
    base: Tables,
    design: Design,
    coefficients: Floats,
    track_scatter: float,
    runs: BlockRuns,
    near: bool,
) -> list[Spelled]:
    """Every value of one candidate that the screening tries.

    What needs tables of its own is spelled out when it is asked for; these are right `near` the
    records alone, or all over.
    """
    setting, key = definition.changes, definition.key
    if setting is None:
        observations = posterior.observations
        effect = definition.build(definition.facts(observations.columns, observations.sites))
        if isinstance(effect, FrictionEffect):
            wider = with_columns(design, effect, effect.design(observations.columns))
            return [AtHand([Alternative(key, base, wider, 0.0)])]
        if isinstance(effect, VolumeErrorEffect):
            read = volume_error_designs(effect, posterior, u, design)
            return [AtHand([Alternative(key, base, other, prior) for other, prior in read])]
        return _tabulated(effect, posterior, u, design, track_scatter, runs, near, base.about)
    if setting.field == "law":
        mine = posterior.specification.law
        names = [name for name, item in LAWS.items() if name != mine and item.uses_volume]
        designs = [law_design(posterior, u, name, design, coefficients) for name in names]
        laws = [Alternative(key, base, other, 0.0, other_law=True) for other in designs]
        return [AtHand(laws)]
    if setting.field == "scatter":
        slopes = scatter_slope_designs(posterior.volumes(u), design)
        return [AtHand([Alternative(key, base, other, prior) for other, prior in slopes])]
    changed = posterior.specification.put(setting, setting.value)
    return [partial(_put, key, posterior, u, changed, design, track_scatter, base.about)]


def _put(
    key: str,
    posterior: Posterior,
    u: Floats,
    changed: Specification,
    design: Design,
    track_scatter: float,
    about: Floats,
) -> list[Alternative]:
    """The model with another setting of the block."""
    observations = posterior.observations
    tables = model_tables(
        observations,
        posterior.effects,
        posterior.layout.effect_values(u),
        float(changed.centrifugal),
        observations.limit,
        track_scatter,
        about,
    )
    return [Alternative(key, tables, design, 0.0)]


def _tabulated(
    effect: Effect,
    posterior: Posterior,
    u: Floats,
    design: Design,
    track_scatter: float,
    runs: BlockRuns,
    near: bool,
    about: Floats,
) -> list[Spelled]:
    """An effect on the motion or on the record: tables for each value that is tried."""
    told = posterior, u, design, track_scatter, runs, near, about
    return [
        partial(_tabulated_at, effect, values, log_prior, *told)
        for values, log_prior in _values_tried(effect, posterior, u)
    ]


def _tabulated_at(
    effect: Effect,
    values: Floats,
    log_prior: float,
    posterior: Posterior,
    u: Floats,
    design: Design,
    track_scatter: float,
    runs: BlockRuns,
    near: bool,
    about: Floats,
) -> list[Alternative]:
    observations = posterior.observations
    limit, margin = observations.limit, None
    if isinstance(effect, LimitEffect):
        limit, margin = effect.limit(observations.columns, values), float(values[0])
    effects = (*posterior.effects, effect)
    all_values = {**posterior.layout.effect_values(u), effect.key: values}
    shares = SPEED_SHARES if observations.speeds else (1.0,)
    whole = model_tables(
        observations,
        effects,
        all_values,
        float(posterior.specification.centrifugal),
        limit,
        track_scatter,
        about,
        None if isinstance(effect, MotionEffect) else runs,
        near,
    )
    tables = [with_scatter(whole, share * track_scatter) for share in shares]
    return [Alternative(effect.key, each, design, log_prior, margin) for each in tables]


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
