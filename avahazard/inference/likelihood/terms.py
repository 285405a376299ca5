"""Log likelihood of each event, and its derivatives in location and scatter of friction.

Sums over nodes of a density of friction, in loops that compile to vectors. Normal: exp x by x = n
log 2 + r with a whole n and |r| ≤ log(2) / 2; exp r is its Taylor series to r^12, and 2^n is
written into the bits of a float. Student's: with z = (ν - m) / σ and s = 1 / (1 + z²/4) the density
is STUDENT_PEAK s^(5/2) / σ.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.model.friction_model import (
    NORMAL_PEAK,
    STUDENT_PEAK,
    STUDENT_PULL,
    normal_below,
    normal_density,
    student_below,
    student_density,
)
from avahazard.kernels import bare, kernel

LOWEST = -708.0
"""What is below counts as this: exp is then 3e-308."""
WHOLE = 1.5 * 2.0**52
"""Added to a number, it leaves the nearest whole one in the lowest bits."""
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
"""Bits of √½."""
PER_LOG_2 = 1.4426950408889634
LOG_2_HIGH, LOG_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""log 2 in two parts, of which the first times a whole number is exact (Cody and Waite 1980)."""
EXP_SERIES = tuple(1.0 / math.factorial(k) for k in range(12, -1, -1))
LOG_SERIES = tuple(1.0 / k for k in range(21, 1, -2))
"""Coefficients of the series, that of the highest power first."""


class ExpMemory(NamedTuple):
    """Working memory for n numbers, `[n]`; `whole_bits`, `power` share that of those before."""

    whole: Floats
    whole_bits: NDArray[np.int64]
    power_bits: NDArray[np.int64]
    power: Floats


@kernel(inner=True)
def exp_memory(n: int) -> ExpMemory:
    """Working memory for n numbers."""
    whole, power_bits = np.empty(n), np.empty(n, dtype=np.int64)
    return ExpMemory(whole, whole.view(np.int64), power_bits, power_bits.view(np.float64))


@kernel(inner=True, forceinline=True)
def exponentials(x: Floats, n: int, memory: ExpMemory) -> None:
    """Put exp in the place of the first n numbers of x, which are 708 or less, or nan."""
    whole, whole_bits, power_bits, power = memory
    # One short loop after the other, of few arrays each: so they compile to vectors.
    for k in range(n):
        whole[k] = (LOWEST if x[k] < LOWEST else x[k]) * PER_LOG_2 + WHOLE
    for k in range(n):
        power_bits[k] = (whole_bits[k] + 1023) << 52
    for k in range(n):
        times = whole[k] - WHOLE
        r = (LOWEST if x[k] < LOWEST else x[k]) - times * LOG_2_HIGH
        r -= times * LOG_2_LOW
        series = EXP_SERIES[0]
        for coefficient in EXP_SERIES[1:]:
            series = series * r + coefficient
        x[k] = series
    for k in range(n):
        x[k] *= power[k]


@kernel(inner=True, forceinline=True)
def logarithms(x: Floats, x_bits: NDArray[np.int64], n: int, memory: ExpMemory) -> None:
    """Put log in the place of the first n numbers of x, normal floats over 0 of bits `x_bits`."""
    whole, _, power_bits, _ = memory
    for k in range(n):
        power_bits[k] = (x_bits[k] - ROOT_HALF_BITS) >> 52
    for k in range(n):
        whole[k] = power_bits[k]
    for k in range(n):
        x_bits[k] -= power_bits[k] << 52
    for k in range(n):
        part = (x[k] - 1.0) / (x[k] + 1.0)
        square = part * part
        series = LOG_SERIES[0]
        for coefficient in LOG_SERIES[1:]:
            series = series * square + coefficient
        rest = 2.0 * part + 2.0 * part * square * series + whole[k] * LOG_2_LOW
        x[k] = whole[k] * LOG_2_HIGH + rest


LANES = 8
"""Numbers of the widest registers: the nodes are filled up to a multiple of these."""


class SumMemory(NamedTuple):
    """Working memory for the nodes of one event, volume after volume; `shape` is Student's s."""

    z: Floats
    density: Floats
    shape: Floats
    exp: ExpMemory


@kernel(inner=True)
def sum_memory(n: int) -> SumMemory:
    """Working memory for n nodes."""
    n += LANES
    return SumMemory(np.zeros(n), np.zeros(n), np.zeros(n), exp_memory(n))


@kernel(inner=True)
def density_sums(place, weight, location, scatter, lift, student, slopes, memory, out):  # type: ignore[no-untyped-def]
    """Σ w p(ν | m, σ) e^lift for each volume, and its derivatives in m, log σ, and twice in m.

    `place`, `weight` `[n_nodes]`, `location`, `scatter` `[n_volumes]`, `out` `[n_volumes, 4]`;
    derivatives are 0 unless `slopes`. Student's needs no lift, and has none.
    """
    _fill_densities(place, location, scatter, lift, student, memory)
    z, density, shape = memory.z, memory.density, memory.shape
    n = len(place)
    for q in range(len(location)):
        per_sigma = 1.0 / scatter[q]
        scale = (STUDENT_PEAK if student else NORMAL_PEAK) * per_sigma
        value, first, by_scatter, second = 0.0, 0.0, 0.0, 0.0
        for k in range(n):
            j = q * n + k
            a = weight[k] * density[j]
            value += a
            if slopes and student:
                pull = STUDENT_PULL * z[j] * shape[j]
                first += a * pull
                by_scatter += a * pull * z[j]
                second += a * (1.4 * pull * pull - STUDENT_PULL * shape[j])
            elif slopes:
                a *= z[j]
                first += a
                by_scatter += a * z[j]
        if not student:
            second = by_scatter - value
        out[q, 0] = value * scale
        out[q, 1] = first * scale * per_sigma if slopes else 0.0
        out[q, 2] = (by_scatter - value) * scale if slopes else 0.0
        out[q, 3] = second * scale * per_sigma * per_sigma if slopes else 0.0


@kernel(inner=True)
def _fill_densities(place, location, scatter, lift, student, memory):  # type: ignore[no-untyped-def]
    """Fill `SumMemory` for the nodes of all volumes, the densities less their peak."""
    z, density, shape = memory.z, memory.density, memory.shape
    n = len(place)
    for q in range(len(location)):
        per_sigma, m = 1.0 / scatter[q], location[q]
        for k in range(n):
            z[q * n + k] = (place[k] - m) * per_sigma
    whole = (len(location) * n + LANES - 1) // LANES * LANES
    if not student:
        for k in range(whole):
            density[k] = lift - 0.5 * z[k] * z[k]
        exponentials(density, whole, memory.exp)
        return
    for k in range(whole):
        shape[k] = 1.0 / (1.0 + 0.25 * z[k] * z[k])
    for k in range(whole):
        density[k] = shape[k] * shape[k] * np.sqrt(shape[k])


@kernel(inner=True)
def _add_edges(place, weight, outer, location, scatter, student, slopes, sums):  # type: ignore[no-untyped-def]
    """Add Σ w P(ν < ν_k | m, σ) and, with `slopes`, its derivatives to `density_sums`.

    Of two edges that are `outer` ones the second counts by P(ν > ν_k).
    """
    for q in range(len(location)):
        m, sigma, out = location[q], scatter[q], sums[q]
        for k in range(len(place)):
            if weight[k] == 0.0:
                continue
            sign = -1.0 if outer and k == 1 else 1.0
            z = (place[k] - m) / sigma
            out[0] += weight[k] * (student_below(sign * z) if student else normal_below(sign * z))
            if not slopes:
                continue
            if student:
                pdf, pull, _ = student_density(z)
            else:
                pdf, pull = normal_density(z), z
            pdf *= sign * weight[k]
            out[1] -= pdf / sigma
            out[2] -= z * pdf
            out[3] -= pull * pdf / (sigma * sigma)


TINY = 1e-290
UNDERFLOW = 1e-200


class EventTerms(NamedTuple):
    """Per event: log likelihood `value` `[n_events]` and its derivatives.

    `by_location`, `by_scatter` `[n_events, n_volumes]` are derivatives in m and log σ at each
    volume node; `curvature` `[n_events]` is the second derivative in a shift common to all m.
    Without slopes one row of them serves all.
    """

    value: Floats
    by_location: Floats
    by_scatter: Floats
    curvature: Floats


@kernel
def event_terms_kernel(nodes, volume_weight, student, keep, slopes, location, scatter):  # type: ignore[no-untyped-def]
    """The arrays of `EventTerms`, as `event_terms` has them, and the sum of the values."""
    n, n_volumes = location.shape
    shape = (n if slopes else 1), n_volumes
    terms = np.zeros(n), np.zeros(shape), np.zeros(shape), np.zeros(n)
    memory, room = sum_memory(n_volumes * nodes.place.shape[1]), np.zeros((6, n_volumes))
    friction = volume_weight, location, scatter
    total = _fill_terms(nodes, friction, student, keep, slopes, memory, room, terms)
    return *terms, total


@kernel
def _fill_terms(nodes, friction, student, keep, slopes, memory, room, terms):  # type: ignore[no-untyped-def]
    """Fill the arrays of `EventTerms`, and return the sum of the values.

    Apart from what makes them, which holds all arrays. `room` `[6, n_volumes]` is memory for sums.
    """
    nodes, keep, memory, room = bare(nodes), bare(keep), bare(memory), bare(room)
    volume_weight, location, scatter = bare(friction)
    values, by_location, by_scatter, curvature = bare(terms)
    part, seen_location, seen_scatter = room[:4].T, room[4], room[5]
    total = 0.0
    for i in range(len(location)):
        if not keep[i]:
            continue
        m, sigma, weights, used = location[i], scatter[i], volume_weight[i], nodes.used[i]
        lift = _add_to_sums(nodes, i, m, sigma, student, slopes, memory, part)
        row = i if slopes else 0
        of_location, of_scatter = by_location[row], by_scatter[row]
        chance, bend = _gather(part, weights, nodes.floor[i], of_location, of_scatter)
        value = np.log(max(chance, TINY)) + nodes.log_scale[i] - lift
        if nodes.has_limit[i]:
            place, weight = nodes.seen_place[i, :used], nodes.seen_weight[i, :used]
            part[:] = 0.0
            _add_edges(place, weight, False, m, sigma, student, slopes, part)
            chance, seen_bend = _gather(
                part, weights, nodes.seen_floor[i], seen_location, seen_scatter
            )
            value -= np.log(max(chance, TINY))
            bend -= seen_bend
            for q in range(len(m)):
                of_location[q] -= seen_location[q]
                of_scatter[q] -= seen_scatter[q]
        if student:
            value, bend = _or_wrong(nodes.log_wrong[i], value, of_location, of_scatter, bend)
        values[i], curvature[i] = value, bend
        total += value
    return total


@kernel(inner=True)
def _add_to_sums(nodes, i, location, scatter, student, slopes, memory, part):  # type: ignore[no-untyped-def]
    """Fill `part` with the sums of event i; returns by how much its exponents are lifted far off.

    That is by the largest of them.
    """
    used = nodes.used[i]
    place, weight = nodes.place[i, :used], nodes.weight[i, :used]
    if nodes.is_probability[i]:
        part[:] = 0.0
        _add_edges(place, weight, False, location, scatter, student, slopes, part)
        return 0.0
    lift = 0.0
    for far_off in range(2):
        density_sums(place, weight, location, scatter, lift, student, slopes, memory, part)
        if far_off:
            break
        tail = nodes.tail[i]
        if tail[0] > 0.0 or tail[1] > 0.0:
            edges = nodes.tail_place[i]
            _add_edges(edges, tail, True, location, scatter, student, slopes, part)
        if student or np.max(part[:, 0]) >= UNDERFLOW:
            break
        lift = _lift(place, weight, location, scatter)
    return lift


@kernel(inner=True)
def _lift(place, weight, location, scatter):  # type: ignore[no-untyped-def]
    """The least z²/2 of all nodes that count."""
    lift = np.inf
    for q in range(len(location)):
        for k in range(len(place)):
            if weight[k] > 0.0:
                z = (place[k] - location[q]) / scatter[q]
                lift = min(lift, 0.5 * z * z)
    return lift


@kernel(inner=True)
def _or_wrong(log_wrong, value, by_location, by_scatter, curvature):  # type: ignore[no-untyped-def]
    """log(exp(value) + exp(log_wrong)) and its derivatives; returns it and its curvature."""
    if log_wrong < value - 700.0:
        return value, curvature
    top = max(value, log_wrong)
    total = top + np.log(np.exp(value - top) + np.exp(log_wrong - top))
    right = np.exp(value - total)
    slope = 0.0
    for q in range(len(by_location)):
        slope += by_location[q]
        by_location[q] *= right
        by_scatter[q] *= right
    return total, right * (curvature + (1.0 - right) * slope * slope)


@kernel(inner=True)
def _gather(part, weight, floor, by_location, by_scatter):  # type: ignore[no-untyped-def]
    """Sum over volume nodes; log derivatives; returns the sum and the second log derivative."""
    total, first, second = floor, 0.0, 0.0
    for q in range(len(weight)):
        total += weight[q] * part[q, 0]
        first += weight[q] * part[q, 1]
        second += weight[q] * part[q, 3]
    safe = max(total, TINY)
    for q in range(len(weight)):
        by_location[q] = weight[q] * part[q, 1] / safe
        by_scatter[q] = weight[q] * part[q, 2] / safe
    return total, second / safe - (first / safe) ** 2


def event_terms(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: Bools | None = None,
    *,
    slopes: bool = True,
) -> EventTerms:
    """log Σ_q h_q Σ_k w_k p(ν_k | m_q, σ_q) of each event, less the log chance to be seen.

    `location` m and `scatter` σ > 0 `[n_events, n_volumes]` at the volume nodes with weights
    `volume_weight` h. Friction scatters normally about m, or with `student` as Student's t,
    a few records being grossly wrong (`nodes.log_wrong`). Terms of events not in `keep`
    `[n_events]` are 0. Without `slopes` the values alone are good, and their last bit may be
    another; it takes less time.
    """
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    of_events = nodes, volume_weight, student, keep, slopes
    return EventTerms(*event_terms_kernel(*of_events, location, scatter)[:-1])
