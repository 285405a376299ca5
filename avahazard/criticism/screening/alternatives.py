"""Candidate effects spelled out for the screening.

Their tables and designs do not change between made worlds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avahazard.criticism.screening.laplace_fit import Design, Edges
from avahazard.criticism.screening.record_moments import SpeedGrid, record_bounds
from avahazard.effects.effect import Definition, Effect, Floats
from avahazard.effects.error_factor import HALF_OCTAVES
from avahazard.inference.fitting.mode_search import thinned
from avahazard.inference.fitting.units import units
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import BlockRuns, Predicted, predict_records
from avahazard.inference.likelihood.speed_errors import whitening
from avahazard.inference.likelihood.speed_nodes import squares
from avahazard.inference.model.friction_scatter import volume_share
from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.model.observations import LENGTH, Observations
from avahazard.inference.model.offset_plan import OffsetPlan
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import VolumeNodes, rescaled
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU, MU_STEP

LOG_MU = np.log(MU)
SPEED_STRIDE = 4
GRID_POINTS, OTHER_POINTS = 6, 4
"""Values tried of the first parameter of an effect that needs tables, and of each other one."""
SLOW_POINTS = 3, 3
"""The same where friction depends on speed, whose runs cost ten times as much."""
SCATTER_SLOPES = (-1.5, -0.8, -0.4, 0.4, 0.8, 1.5)
"""Slopes of log scatter over the reference volume that are tried."""
MOST_EXPONENT = 20.0
SPEED_SHARES = (1.0, 0.4)
"""Shares of the model's present error of speed that are tried with an effect: it may fall."""


@dataclass(frozen=True, slots=True, eq=False)
class Tables:
    """What one set of tables says of every event.

    `record` `[n_events, n_friction]` (float32) and its `record_bounds`, `last_left` `[n_events]`,
    `height` `[n_events]` of fall (m) where there is no profile (else nan), `sigma` `[n_events]` (m)
    of the records, edges of leaving and of sight, and speeds.
    """

    record: NDArray[np.float32]
    bounds: NDArray[np.float32]
    last_left: NDArray[np.int64]
    height: Floats
    sigma: Floats
    edges: Edges
    speeds: SpeedGrid


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


def base_design(posterior: Posterior, u: Floats, plan: OffsetPlan, scale: Floats) -> Design:
    """Design of the model itself: its law, linear about u, and its effects on friction.

    Offsets of groups are those of `plan`, their spreads have half-normal priors of this `scale`
    `[n_groupings]`.
    """
    slots = [posterior.layout.slots[k] for k in _inner(posterior)]
    x, constant, extra, multiplier = _read_by_volume(posterior, u, posterior.volumes(u))
    return Design(
        x=x,
        constant=constant,
        prior_mean=np.array([s.mean for s in slots]),
        prior_precision=np.array([s.sd**-2.0 for s in slots]),
        of=plan.of,
        places=plan.index,
        alone=plan.alone,
        rest=plan.rest,
        spread_scale=scale,
        extra=extra,
        multiplier=multiplier,
        log_wrong=_odds_of_wrong(posterior, u),
    )


def _inner(posterior: Posterior) -> list[int]:
    """Slots of the coefficients; effects on the tables and on the errors keep their values."""
    inner = list(range(len(posterior.layout.law.coordinates)))
    for effect in posterior.effects:
        if effect.design is not None:
            place = posterior.layout.places[effect.key]
            inner += list(range(place.start, place.stop))
    return inner


def _read_by_volume(
    posterior: Posterior, u: Floats, volumes: VolumeNodes
) -> tuple[Floats, Floats, Floats, Floats]:
    """The `x`, `constant`, `extra` and `multiplier` of a design, given the true volumes."""
    inner = _inner(posterior)
    mean = _mean_log_friction(posterior, u, volumes)
    x = np.empty((posterior.observations.n_events, len(inner)))
    small = 1e-4 * units(posterior)
    for c, k in enumerate(inner):
        step = np.zeros(len(u))
        step[k] = small[k]
        up, down = (_mean_log_friction(posterior, u + d, volumes) for d in (step, -step))
        x[:, c] = (up - down) / (2.0 * small[k])
    _, scatter = posterior.location_and_scatter(u, volumes.volume)
    middle = np.exp(np.average(np.log(scatter), axis=1, weights=volumes.weight[0]))
    return (
        x,
        mean - x @ u[inner],
        _volume_variance(posterior, u, volumes),
        middle / np.exp(np.mean(np.log(middle))),
    )


def _odds_of_wrong(posterior: Posterior, u: Floats) -> Floats:
    """`Posterior.log_wrong` over the share of records that are right."""
    place = posterior.layout.wrong_share
    right = 0.0 if place is None else float(np.log1p(-np.exp(u[place])))
    return np.asarray(posterior.log_wrong(u) - right)


def base_coordinates(posterior: Posterior, u: Floats) -> Floats:
    """The values at u of the coefficients of `base_design`."""
    return np.asarray(u[_inner(posterior)])


def make_tables(
    observations: Observations, predicted: Predicted, limit: Floats, speed_scatter: float
) -> Tables:
    """Tables in the screening's form; `limit` `[n_events]` as in `Observations`."""
    left = predicted.status == LEFT_PROFILE
    n = len(left)
    last_left = np.where(left.any(axis=1), left.shape[1] - 1 - np.argmax(left[:, ::-1], axis=1), -1)
    leave = np.where(
        last_left >= 0, LOG_MU[np.clip(last_left, 0, None)] + 0.5 * MU_STEP / MU[last_left], -9.0
    )
    has_limit = np.isfinite(limit) & np.isfinite(predicted.elevation).all(axis=1)
    seen, seen_sd = np.full(n, 9.0), np.zeros(n)
    for i in np.flatnonzero(has_limit):
        chance = ndtr((limit[i] - predicted.elevation[i]) / predicted.sigma[i])
        chance = np.minimum.accumulate(np.where(left[i], 1.0, chance))
        drop = -np.diff(chance)
        total = float(np.sum(drop))
        if total < 1e-6:
            has_limit[i] = False
            continue
        middle = 0.5 * (LOG_MU[1:] + LOG_MU[:-1])
        seen[i] = float(np.sum(drop * middle)) / total
        seen_sd[i] = np.sqrt(max(float(np.sum(drop * (middle - seen[i]) ** 2)) / total, 0.0))
    record = predicted.record.astype(np.float32)
    return Tables(
        record=record,
        bounds=record_bounds(record),
        last_left=last_left.astype(np.int64),
        height=np.where(observations.kind == LENGTH, observations.fall_height, np.nan),
        sigma=predicted.sigma,
        edges=Edges(leave, seen, seen_sd, has_limit),
        speeds=_speed_grid(observations, predicted, speed_scatter),
    )


def _speed_grid(observations: Observations, predicted: Predicted, scatter: float) -> SpeedGrid:
    row = np.full(observations.n_events, -1, dtype=np.int64)
    widest = max((len(m.x) for m in observations.speeds), default=1)
    n_rows = max(1, len(observations.speeds))
    coarse = np.zeros((n_rows, len(MU[::SPEED_STRIDE]), widest), dtype=np.float32)
    whiten = np.zeros((n_rows, widest, widest))
    log_norm = np.zeros(n_rows)
    for r, (measured, speeds) in enumerate(zip(observations.speeds, predicted.speeds, strict=True)):
        k = len(measured.x)
        row[measured.event] = r
        coarse[r, :, :k] = squares(speeds[::SPEED_STRIDE])
        whiten[r, :k, :k], log_norm[r] = whitening(measured.x, measured.sigma, scatter)
    return SpeedGrid(row, coarse, whiten, log_norm, SPEED_STRIDE)


def alternatives_of(
    definition: Definition,
    posterior: Posterior,
    u: Floats,
    base: Tables,
    design: Design,
    coefficients: Floats,
    speed_scatter: float,
    runs: BlockRuns,
) -> list[Spelled]:
    """Every value of one candidate that the screening tries.

    What needs tables of its own is spelled out when it is asked for.
    """
    setting, key = definition.changes, definition.key
    if setting is None:
        observations = posterior.observations
        effect = definition.build(definition.facts(observations.columns, observations.sites))
        if effect.design is not None:
            wider = _with_columns(design, effect, effect.design(observations.columns))
            return [AtHand([Alternative(key, base, wider, 0.0)])]
        if effect.volume_scale is not None:
            return [AtHand(_volume_errors(effect, posterior, u, base, design))]
        return _tabulated(effect, posterior, u, design, speed_scatter, runs)
    if setting.field == "law":
        mine = posterior.specification.law
        names = [name for name, item in LAWS.items() if name != mine and item.uses_volume]
        designs = [_law_design(posterior, u, name, design, coefficients) for name in names]
        laws = [Alternative(key, base, other, 0.0, other_law=True) for other in designs]
        return [AtHand(laws)]
    if setting.field == "scatter":
        return [AtHand(_scatter_slopes(key, posterior.volumes(u), base, design))]
    changed = posterior.specification.put(setting, setting.value)
    return [partial(_put, key, posterior, u, changed, design, speed_scatter)]


def _put(
    key: str,
    posterior: Posterior,
    u: Floats,
    changed: Specification,
    design: Design,
    speed_scatter: float,
) -> list[Alternative]:
    """The model with another setting of the block."""
    return [Alternative(key, _tables_of(posterior, u, changed, speed_scatter), design, 0.0)]


def _volume_errors(
    effect: Effect, posterior: Posterior, u: Floats, base: Tables, design: Design
) -> list[Alternative]:
    """True volumes read with other errors than the stated ones."""
    assert effect.volume_scale is not None
    (p,) = effect.parameters
    tried = [v for v in HALF_OCTAVES[::2] if v < p.high and v != p.neutral]
    if p.high > p.neutral:
        tried.append(p.high)
    result = []
    for v in tried:
        volumes = rescaled(posterior.volumes(u), effect.volume_scale(np.array([v])))
        x, constant, extra, multiplier = _read_by_volume(posterior, u, volumes)
        other = design._replace(x=x, constant=constant, extra=extra, multiplier=multiplier)
        log_prior = -0.5 * ((v - p.prior_mean) / p.prior_sd) ** 2
        result.append(Alternative(effect.key, base, other, log_prior))
    return result


def _tables_of(
    posterior: Posterior, u: Floats, specification: Specification, speed_scatter: float
) -> Tables:
    """Tables of the model's own effects with other settings of the block."""
    observations = posterior.observations
    values = posterior.layout.effect_values(u)
    curvature = float(specification.centrifugal)
    predicted = predict_records(observations, posterior.effects, values, curvature)
    return make_tables(observations, predicted, observations.limit, speed_scatter)


def _scatter_slopes(
    key: str, volumes: VolumeNodes, base: Tables, design: Design
) -> list[Alternative]:
    """Scatter that grows or falls with volume."""
    volume = np.exp(volumes.mean)
    share = volume_share(volume, float(np.quantile(volume, 0.9)))
    return [
        Alternative(
            key,
            base,
            design._replace(multiplier=design.multiplier * _grown(g * (share.mean() - share))),
            -0.5 * g * g,
        )
        for g in SCATTER_SLOPES
    ]


def _grown(exponent: Floats) -> Floats:
    """e to this power, kept a number where one volume dwarfs the rest."""
    return np.exp(np.clip(exponent, -MOST_EXPONENT, MOST_EXPONENT))


def _with_columns(design: Design, effect: Effect, columns: Floats) -> Design:
    """The design with the columns of an effect on friction."""
    sd = np.array([p.prior_sd for p in effect.parameters])
    return design._replace(
        x=np.column_stack([design.x, columns]),
        prior_mean=np.append(design.prior_mean, np.zeros(len(sd))),
        prior_precision=np.append(design.prior_precision, sd**-2.0),
    )


def _tabulated(
    effect: Effect,
    posterior: Posterior,
    u: Floats,
    design: Design,
    speed_scatter: float,
    runs: BlockRuns,
) -> list[Spelled]:
    """An effect on the motion or on the record: tables for each value that is tried."""
    return [
        partial(_tabulated_at, effect, values, log_prior, posterior, u, design, speed_scatter, runs)
        for values, log_prior in _values_tried(effect)
    ]


def _tabulated_at(
    effect: Effect,
    values: Floats,
    log_prior: float,
    posterior: Posterior,
    u: Floats,
    design: Design,
    speed_scatter: float,
    runs: BlockRuns,
) -> list[Alternative]:
    observations = posterior.observations
    limit = observations.limit
    if effect.limit is not None:
        limit = effect.limit(observations.columns, values)
    predicted = predict_records(
        observations,
        (*posterior.effects, effect),
        {**posterior.layout.effect_values(u), effect.key: values},
        float(posterior.specification.centrifugal),
        runs if effect.motion is None else None,
    )
    margin = float(values[0]) if effect.limit is not None else None
    shares = SPEED_SHARES if observations.speeds else (1.0,)
    tables = [make_tables(observations, predicted, limit, s * speed_scatter) for s in shares]
    return [Alternative(effect.key, each, design, log_prior, margin) for each in tables]


def _values_tried(effect: Effect) -> list[tuple[Floats, float]]:
    """Values of the parameters on a thinned grid, and their log prior against neutral."""
    first, *others = effect.parameters
    away = [g for g in first.grid if g != first.neutral]
    n_first, n_other = SLOW_POINTS if effect.speed_dependent else (GRID_POINTS, OTHER_POINTS)
    tried = []
    for corner in product(thinned(away, n_first), *(thinned(p.grid, n_other) for p in others)):
        z = (corner[0] - first.prior_mean) / first.prior_sd
        z0 = (first.neutral - first.prior_mean) / first.prior_sd
        tried.append((np.array(corner), 0.5 * (z0 * z0 - z * z)))
    return tried


def _law_design(
    posterior: Posterior, at: Floats, name: str, design: Design, coefficients: Floats
) -> Design:
    """The design with another law, linear about its least-squares fit to the present one."""
    volumes = posterior.volumes(at)
    other = law(name)
    n_old = len(posterior.layout.law.coordinates)
    volume = volumes.volume
    weight = volumes.weight
    mu = np.exp(design.constant + design.x[:, :n_old] @ coefficients[:n_old])
    u = other.start(np.exp(volumes.mean), mu)
    if name == "power":
        u = np.array([np.log(np.median(mu)), 0.05])

    def mean(v: Floats) -> Floats:
        values = other.log_friction(v, volume.ravel()).reshape(volume.shape)
        return np.asarray(np.sum(values * weight, axis=1))

    columns = [(mean(u + step) - mean(u - step)) / 2e-3 for step in 1e-3 * np.eye(len(u))]
    x = np.column_stack([*columns, design.x[:, n_old:]])
    return design._replace(
        x=x,
        constant=mean(u) - np.column_stack(columns) @ u,
        prior_mean=np.append(other.prior_mean, design.prior_mean[n_old:]),
        prior_precision=np.append(other.prior_sd**-2.0, design.prior_precision[n_old:]),
    )


def _mean_log_friction(posterior: Posterior, u: Floats, volumes: VolumeNodes) -> Floats:
    location, _ = posterior.location_and_scatter(u, volumes.volume)
    if not posterior.layout.log_scatter:
        location = np.log(np.maximum(location, 1e-3))
    return np.asarray(np.sum(location * volumes.weight, axis=1))


def _volume_variance(posterior: Posterior, u: Floats, volumes: VolumeNodes) -> Floats:
    location, _ = posterior.location_and_scatter(u, volumes.volume)
    weight = volumes.weight
    mean = np.sum(location * weight, axis=1, keepdims=True)
    return np.asarray(np.sum((location - mean) ** 2 * weight, axis=1))
