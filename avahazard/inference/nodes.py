"""Quadrature nodes over friction: what a record says about the friction of its event.

For each event, p(record | μ) is a narrow bump over friction. It is summed up by the nodes of the
Gauss quadrature that has it as weight (Golub and Welsch 1969), so that

    p(record | m, σ) = ∫ p(record | μ) p(ν | m, σ) dν ≈ Σ_k w_k p(ν_k | m, σ),  ν = log μ,

costs a few evaluations of the scatter density. No inverse of F is needed: where F jumps, the
bump has two parts. Events that left the profile give a probability instead,
w₀ + Σ_k w_k P(ν < ν_k), and so does the chance that a stop low enough was seen.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.inference.predicted import Predicted
from avahazard.inference.speed_nodes import between, speed_log_likelihood
from avahazard.inference.study import LEFT, SpeedRecord, Study
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.constants import KEEPS_NAN
from avahazard.physics.runout_table import MU

Floats = NDArray[np.float64]

N_NODES = 10
REACH = 7.0
"""Records farther than this many standard deviations from F(μ) say nothing about μ."""
PIECE = 0.5
"""Largest step of F, in standard deviations of the record, between two points of a bump."""


class Nodes(NamedTuple):
    """Nodes of all events, `[n_events, N_NODES]`; `place` is ν, or μ for normal scatter.

    `is_probability` `[n_events]`: the event left its profile, and its nodes are edges of
    probabilities. `log_scale` `[n_events]` is the log of what all weights are multiplied by,
    `floor` `[n_events]` is w₀, `log_wrong` `[n_events]` as in `wrong_records` (or -inf).
    `seen_place`, `seen_weight`, `seen_floor` give the chance to be seen, where `has_limit`.
    """

    place: Floats
    weight: Floats
    log_scale: Floats
    is_probability: NDArray[np.bool_]
    floor: Floats
    seen_place: Floats
    seen_weight: Floats
    seen_floor: Floats
    has_limit: NDArray[np.bool_]
    log_wrong: Floats


def build_nodes(
    study: Study,
    predicted: Predicted,
    speed_scatter: float = 0.0,
    limit: Floats | None = None,
    in_log: bool = True,
) -> Nodes:
    """Nodes of every event for one set of tables.

    `speed_scatter` (m/s) is the standard deviation of the model's own error of speed, correlated
    along the track; `limit` `[n_events]` replaces the study's elevations above which a stop is
    not seen; `in_log` gives nodes in log μ, else in μ.
    """
    records = record_nodes(study, predicted, limit, in_log)
    return speed_nodes(records, study, predicted, speed_scatter, in_log)


def record_nodes(
    study: Study, predicted: Predicted, limit: Floats | None = None, in_log: bool = True
) -> Nodes:
    """Nodes of the events without speeds; those of the others are left blank."""
    has_speed = np.zeros(study.n_events, dtype=np.bool_)
    has_speed[[m.event for m in study.speeds]] = True
    seen_limit = study.limit if limit is None else limit
    built = _build(
        predicted.record,
        np.nan_to_num(predicted.elevation, nan=0.0),
        predicted.status == LEFT_PROFILE,
        study.kind == LEFT,
        study.observed,
        study.sigma,
        np.where(np.isnan(predicted.elevation).all(axis=1), np.nan, seen_limit),
        has_speed,
        np.log(MU) if in_log else MU,
    )
    return Nodes(*built, np.full(study.n_events, -np.inf))  # type: ignore[call-arg]


def speed_nodes(
    records: Nodes, study: Study, predicted: Predicted, speed_scatter: float, in_log: bool = True
) -> Nodes:
    """`record_nodes` with those of the events with speeds filled in."""
    if not study.speeds:
        return records
    nodes = records._replace(
        place=records.place.copy(),
        weight=records.weight.copy(),
        log_scale=records.log_scale.copy(),
    )
    for measured, speeds in zip(study.speeds, predicted.speeds, strict=True):
        _bump_with_speeds(nodes, study, predicted, measured, speeds, speed_scatter, in_log)
    return nodes


def _bump_with_speeds(
    nodes: Nodes,
    study: Study,
    predicted: Predicted,
    measured: SpeedRecord,
    speeds: Floats,
    scatter: float,
    in_log: bool,
) -> None:
    """Fill in the nodes of an event with speeds."""
    i = measured.event
    observed_left = bool(study.kind[i] == LEFT)
    record, left = predicted.record[i], predicted.status[i] == LEFT_PROFILE

    def log_likelihood(u: Floats) -> Floats:
        return np.asarray(
            speed_log_likelihood(measured.x, measured.speed, measured.sigma, u, scatter)
        )

    ends = log_likelihood(speeds)
    best = np.maximum(ends[1:], ends[:-1])
    if observed_left:
        best = np.where(left[1:] | left[:-1], best, -np.inf)
    else:
        z = (record - study.observed[i]) / study.sigma[i]
        nearest = np.where(z[1:] * z[:-1] <= 0.0, 0.0, np.minimum(np.abs(z[1:]), np.abs(z[:-1])))
        best = np.where(left[1:] & left[:-1], -np.inf, best - 0.5 * nearest**2)
    if not np.any(np.isfinite(best)):
        best = np.zeros_like(best)
    track = between(MU, record, left, speeds, best, observed_left)
    nodes.log_scale[i] = _bump(
        track.record,
        track.left,
        observed_left,
        study.observed[i],
        study.sigma[i],
        log_likelihood(track.speeds),
        np.log(track.grid) if in_log else track.grid,
        nodes.place[i],
        nodes.weight[i],
    )


@njit(cache=True, fastmath=KEEPS_NAN, nogil=True)
def _build(  # type: ignore[no-untyped-def]
    record, elevation, left, observed_left, observed, sigma, limit, has_speed, grid
):
    n = len(record)
    place = np.zeros((n, N_NODES))
    weight = np.zeros((n, N_NODES))
    log_scale = np.zeros(n)
    is_probability = np.zeros(n, dtype=np.bool_)
    seen_place = np.zeros((n, N_NODES))
    seen_weight = np.zeros((n, N_NODES))
    floor = np.zeros(n)
    seen_floor = np.ones(n)
    has_limit = np.zeros(n, dtype=np.bool_)
    no_speed = np.zeros(len(grid))
    for i in range(n):
        if observed_left[i] and not has_speed[i]:
            is_probability[i] = True
            floor[i] = _edges_of_leaving(left[i], grid, place[i], weight[i])
        elif not has_speed[i]:
            log_scale[i] = _bump(
                record[i],
                left[i],
                observed_left[i],
                observed[i],
                sigma[i],
                no_speed,
                grid,
                place[i],
                weight[i],
            )
        if not np.isnan(limit[i]):
            has_limit[i] = True
            seen_floor[i] = _edges_of_sight(
                elevation[i], left[i], limit[i], sigma[i], grid, seen_place[i], seen_weight[i]
            )
    return (
        place,
        weight,
        log_scale,
        is_probability,
        floor,
        seen_place,
        seen_weight,
        seen_floor,
        has_limit,
    )


@njit(cache=True, nogil=True)
def _edges_of_leaving(left, grid, place, weight):  # type: ignore[no-untyped-def]
    """P(leaves) = w₀ + Σ w_k P(ν < ν_k): an edge midway wherever the status changes; returns w₀."""
    k = 0
    for j in range(len(left) - 1, 0, -1):
        if left[j - 1] != left[j] and k < len(place):
            place[k] = 0.5 * (grid[j - 1] + grid[j])
            weight[k] = 1.0 if left[j - 1] else -1.0
            k += 1
    return 1.0 if left[len(left) - 1] else 0.0


@njit(cache=True, nogil=True)
def _edges_of_sight(elevation, left, limit, sigma, grid, place, weight):  # type: ignore[no-untyped-def]
    """P(seen) = w₀ + Σ w_k P(ν < ν_k): the chance falls as friction rises; returns w₀."""
    n = len(grid)
    points = np.empty(n)
    drops = np.empty(n)
    count = 0
    level = 1.0
    for j in range(n):
        chance = 1.0 if left[j] else _normal_cdf((limit - elevation[j]) / sigma)
        # Steps of the terrain may raise it again; the running minimum keeps weights positive.
        if level - chance > 1e-9:
            points[count] = grid[j] if j == 0 else 0.5 * (grid[j - 1] + grid[j])
            drops[count] = level - chance
            level = chance
            count += 1
    if count:
        _gauss(points[:count], drops[:count], place, weight)
        weight *= 1.0 - level
    return level


@njit(cache=True, nogil=True)
def _bump(record, left, observed_left, observed, sigma, log_speed, grid, place, weight):  # type: ignore[no-untyped-def]
    """Nodes of p(record | μ); returns the log of its total mass."""
    n = len(grid)
    most = int(np.ceil(2.0 * REACH / PIECE)) + 2
    points = np.empty(most * n)
    logs = np.empty(most * n)
    count = 0
    for j in range(n - 1):
        g0, g1 = grid[j], grid[j + 1]
        l0, l1 = log_speed[j], log_speed[j + 1]
        if observed_left:
            if left[j] or left[j + 1]:
                # The status changes midway between two frictions.
                whole = left[j] and left[j + 1]
                t = 0.5 if whole else (0.25 if left[j] else 0.75)
                points[count] = g0 + t * (g1 - g0)
                logs[count] = np.log((g1 - g0) * (1.0 if whole else 0.5)) + l0 + t * (l1 - l0)
                count += 1
            continue
        if left[j] and left[j + 1]:
            continue
        f0, f1 = record[j], record[j + 1]
        # Across a jump of F, or to the end of the profile, records are taken as spread evenly:
        # real terrain and real avalanches have no such gaps.
        z0, z1 = (f0 - observed) / sigma, (f1 - observed) / sigma
        if min(z0, z1) > REACH or max(z0, z1) < -REACH:
            continue
        first, last = 0.0, 1.0
        if abs(z1 - z0) > PIECE:
            # Only the part of a jump that is within reach of the record counts.
            first = max(0.0, min((-REACH - z0) / (z1 - z0), (REACH - z0) / (z1 - z0)))
            last = min(1.0, max((-REACH - z0) / (z1 - z0), (REACH - z0) / (z1 - z0)))
        if last <= first:
            continue
        pieces = int(np.ceil((last - first) * abs(z1 - z0) / PIECE)) + 1
        step = (last - first) * (g1 - g0) / pieces
        for p in range(pieces):
            t = first + (last - first) * (p + 0.5) / pieces
            z = z0 + t * (z1 - z0)
            points[count] = g0 + t * (g1 - g0)
            logs[count] = -0.5 * z * z - np.log(sigma) - HALF_LOG_2PI + np.log(step)
            logs[count] += l0 + t * (l1 - l0)
            count += 1
    if count == 0:
        return _nearest(record, left, observed, sigma, log_speed, grid, place, weight)
    top = np.max(logs[:count])
    masses = np.exp(logs[:count] - top)
    total = np.sum(masses)
    _gauss(points[:count], masses, place, weight)
    return top + np.log(total)


HALF_LOG_2PI = 0.5 * np.log(2.0 * np.pi)


@njit(cache=True, nogil=True)
def _nearest(record, left, observed, sigma, log_speed, grid, place, weight):  # type: ignore[no-untyped-def]
    """A record that no friction reaches: the nearest friction, at its (tiny) density."""
    best, value = 0, -np.inf
    for j in range(len(grid) - 1):
        if left[j]:
            continue
        z = (record[j] - observed) / sigma
        candidate = -0.5 * z * z + log_speed[j]
        if np.isnan(observed):
            candidate = log_speed[j] - 1e3
        if candidate > value:
            best, value = j, candidate
    place[:], weight[:] = grid[best], 0.0
    weight[0] = 1.0
    if value == -np.inf:
        value = -1e4
    return value - np.log(sigma) - HALF_LOG_2PI + np.log(grid[best + 1] - grid[best])


@njit(cache=True, nogil=True)
def _normal_cdf(z):  # type: ignore[no-untyped-def]
    return 0.5 * math.erfc(-z / np.sqrt(2.0))


@njit(cache=True, nogil=True)
def _gauss(points, masses, place, weight):  # type: ignore[no-untyped-def]
    """Gauss nodes of a discrete measure, weights summing to 1 (Lanczos, reorthogonalised)."""
    n, k_max = len(points), len(place)
    total = np.sum(masses)
    centre = np.sum(points * masses) / total
    reach = np.max(np.abs(points - centre))
    if n <= k_max or reach == 0.0:
        place[:], weight[:] = centre, 0.0
        if reach == 0.0:
            weight[0] = 1.0
        else:
            place[:n], weight[:n] = points, masses / total
        return
    x = (points - centre) / reach
    vectors = np.zeros((k_max + 1, n))
    vectors[0] = np.sqrt(masses / total)
    jacobi = np.zeros((k_max, k_max))
    size = k_max
    for k in range(k_max):
        v = x * vectors[k]
        jacobi[k, k] = np.sum(v * vectors[k])
        for _ in range(2):
            for j in range(k + 1):
                v -= np.sum(v * vectors[j]) * vectors[j]
        norm = np.sqrt(np.sum(v * v))
        if k + 1 == k_max:
            break
        if norm < 1e-10:
            size = k + 1
            break
        jacobi[k, k + 1] = jacobi[k + 1, k] = norm
        vectors[k + 1] = v / norm
    values, eigenvectors = np.linalg.eigh(jacobi[:size, :size])
    place[:], weight[:] = centre, 0.0
    for k in range(size):
        place[k] = centre + reach * values[k]
        weight[k] = eigenvectors[0, k] ** 2
