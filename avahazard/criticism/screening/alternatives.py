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
    VolumeErrorEffect,
)
from avahazard.inference.likelihood.block_runs import BlockRuns
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.specification import Specification

GRID_POINTS, OTHER_POINTS = 6, 4
"""Values tried of the first parameter of an effect that needs tables, and of each other one."""
SLOW_POINTS = 3, 3
"""The same where friction depends on speed, whose runs cost ten times as much."""
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
        for values, log_prior in _values_tried(effect)
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


def _values_tried(effect: Effect) -> list[tuple[Floats, float]]:
    """Values of the parameters on a thinned grid, and their log prior against neutral."""
    first, *others = effect.parameters
    slow = isinstance(effect, MotionEffect) and effect.speed_dependent
    n_first, n_other = SLOW_POINTS if slow else (GRID_POINTS, OTHER_POINTS)
    tried = []
    between = (np.linspace(p.low, p.high, n_other).tolist() for p in others)
    for corner in product(first.plausible(n_first), *between):
        z = (corner[0] - first.prior_mean) / first.prior_sd
        z0 = (first.neutral - first.prior_mean) / first.prior_sd
        tried.append((np.array(corner), 0.5 * (z0 * z0 - z * z)))
    return tried
