"""Sums over nodes of a density of friction, with derivatives, in loops that compile to vectors.

Normal: exp x by x = n log 2 + r with a whole n and |r| ≤ log(2) / 2; exp r is its Taylor series to
r^12, exact to the last digit but one, and 2^n is written into the bits of a float. Student's, of
many events side by side: with z = (ν - m) / σ and a shape s = 1 / (1 + z²/4) the density is
STUDENT_PEAK s^(5/2) / σ, and all derivatives are sums of s^(5/2), s^(7/2), s^(9/2) and z s^(7/2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.model.friction_scatter import NORMAL_PEAK, STUDENT_PEAK, STUDENT_PULL
from avahazard.kernels import kernel

LOWEST = -708.0
"""What is below counts as this: exp is then 3e-308."""
WHOLE = 1.5 * 2.0**52
"""Added to a number, it leaves the nearest whole one in the lowest bits."""
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
"""Bits of √½."""
PER_LOG_2 = 1.4426950408889634
LOG_2_HIGH, LOG_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""log 2 in two parts, of which the first times a whole number is exact (Cody and Waite 1980)."""


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
        series = 1.0 / 479001600.0
        series = series * r + 1.0 / 39916800.0
        series = series * r + 1.0 / 3628800.0
        series = series * r + 1.0 / 362880.0
        series = series * r + 1.0 / 40320.0
        series = series * r + 1.0 / 5040.0
        series = series * r + 1.0 / 720.0
        series = series * r + 1.0 / 120.0
        series = series * r + 1.0 / 24.0
        series = series * r + 1.0 / 6.0
        series = series * r + 0.5
        series = series * r + 1.0
        x[k] = series * r + 1.0
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
        series = 1.0 / 21.0
        series = series * square + 1.0 / 19.0
        series = series * square + 1.0 / 17.0
        series = series * square + 1.0 / 15.0
        series = series * square + 1.0 / 13.0
        series = series * square + 1.0 / 11.0
        series = series * square + 1.0 / 9.0
        series = series * square + 1.0 / 7.0
        series = series * square + 1.0 / 5.0
        series = series * square + 1.0 / 3.0
        rest = 2.0 * part + 2.0 * part * square * series + whole[k] * LOG_2_LOW
        x[k] = whole[k] * LOG_2_HIGH + rest


LANES = 8
"""Numbers of the widest registers: the nodes are filled up to a multiple of these."""


class SumMemory(NamedTuple):
    """Working memory for the nodes of one event, volume after volume."""

    z: Floats
    density: Floats
    exp: ExpMemory


@kernel
def sum_memory(n: int) -> SumMemory:
    """Working memory for n nodes."""
    n += LANES
    return SumMemory(np.zeros(n), np.zeros(n), exp_memory(n))


@kernel(inner=True, forceinline=True)
def _filled(n: int) -> int:
    return (n + LANES - 1) // LANES * LANES


@kernel
def normal_sums(place, weight, location, scatter, lift, slopes, memory, out):  # type: ignore[no-untyped-def]
    """Σ w p(ν | m, σ) e^lift for each volume, and its derivatives in m, log σ, and twice in m.

    `place`, `weight` `[n_nodes]`, `location`, `scatter` `[n_volumes]`, `out` `[n_volumes, 4]`;
    derivatives are 0 unless `slopes`.
    """
    z, density = memory.z, memory.density
    n = len(place)
    for q in range(len(location)):
        per_sigma, m = 1.0 / scatter[q], location[q]
        for k in range(n):
            z[q * n + k] = (place[k] - m) * per_sigma
    whole = _filled(len(location) * n)
    for k in range(whole):
        density[k] = lift - 0.5 * z[k] * z[k]
    exponentials(density, whole, memory.exp)
    for q in range(len(location)):
        per_sigma = 1.0 / scatter[q]
        scale = NORMAL_PEAK * per_sigma
        value, first, second = 0.0, 0.0, 0.0
        for k in range(n):
            a = weight[k] * density[q * n + k]
            value += a
            if slopes:
                a *= z[q * n + k]
                first += a
                second += a * z[q * n + k]
        out[q, 0] = value * scale
        if slopes:
            second -= value
            out[q, 1] = first * scale * per_sigma
            out[q, 2] = second * scale
            out[q, 3] = second * scale * per_sigma * per_sigma
        else:
            out[q, 1], out[q, 2], out[q, 3] = 0.0, 0.0, 0.0


BLOCK = 64
"""Events that are taken side by side."""


class BlockMemory(NamedTuple):
    """Working memory for the nodes of a block of events: `[n_nodes, BLOCK]`, the others `[BLOCK]`.

    `value`, `first`, `seven`, `nine` are the sums of w s^(5/2), w z s^(7/2), w s^(7/2) and
    w s^(9/2); `root` is √s.
    """

    place: Floats
    weight: Floats
    location: Floats
    per_sigma: Floats
    z: Floats
    root: Floats
    value: Floats
    first: Floats
    seven: Floats
    nine: Floats


@kernel
def block_memory(n_nodes: int) -> BlockMemory:
    """Working memory for events of at most so many nodes."""
    place, weight, m = np.zeros((n_nodes, BLOCK)), np.zeros((n_nodes, BLOCK)), np.zeros((8, BLOCK))
    return BlockMemory(place, weight, m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7])


@kernel
def by_nodes_used(used: NDArray[np.int64], keep: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The events to `keep`, those with few nodes first: a block takes as long as its longest."""
    n_with = np.zeros(np.max(used) + 2 if len(used) else 1, dtype=np.int64)
    for i in range(len(used)):
        if keep[i]:
            n_with[used[i] + 1] += 1
    first = np.cumsum(n_with)
    order = np.empty(first[-1], dtype=np.int64)
    for i in range(len(used)):
        if keep[i]:
            order[first[used[i]]] = i
            first[used[i]] += 1
    return order


@kernel
def student_sums(nodes, events, location, scatter, slopes, memory, out):  # type: ignore[no-untyped-def]
    """Σ w p(ν | m, σ) of each event and volume, and its derivatives in m, log σ, and twice in m.

    Of `Nodes` those that are `used`; `location`, `scatter` `[n_events, n_volumes]`; `events` are
    the numbers of a block of events, and `out` `[BLOCK, n_volumes, 4]` is filled for these, its
    derivatives only with `slopes`.
    """
    n_nodes = _nodes_side_by_side(nodes, events, memory)
    m, per_sigma = memory.location, memory.per_sigma
    for q in range(location.shape[1]):
        for e in range(len(events)):
            m[e], per_sigma[e] = location[events[e], q], 1.0 / scatter[events[e], q]
        _sum_powers(n_nodes, slopes, memory)
        for e in range(len(events)):
            rate = per_sigma[e]
            scale, value = STUDENT_PEAK * rate, memory.value[e]
            out[e, q, 0] = scale * value
            if slopes:
                # z² s = 4 (1 - s) turns powers of z into such of s.
                seven, nine = memory.seven[e], memory.nine[e]
                out[e, q, 1] = scale * rate * STUDENT_PULL * memory.first[e]
                out[e, q, 2] = scale * (4.0 * STUDENT_PULL * (value - seven) - value)
                out[e, q, 3] = scale * rate * rate * (7.5 * seven - 8.75 * nine)


@kernel(inner=True)
def _nodes_side_by_side(nodes, events, memory):  # type: ignore[no-untyped-def]
    """Put the nodes of the events side by side; returns how many the longest has."""
    n_nodes = 0
    for e in range(len(events)):
        n_nodes = max(n_nodes, nodes.used[events[e]])
    for e in range(len(events)):
        i = events[e]
        for k in range(n_nodes):
            memory.place[k, e] = nodes.place[i, k]
            memory.weight[k, e] = nodes.weight[i, k] if k < nodes.used[i] else 0.0
    return n_nodes


@kernel(inner=True)
def _sum_powers(n_nodes, slopes, memory):  # type: ignore[no-untyped-def]
    """The sums of `BlockMemory` for one volume."""
    m, per_sigma, z, root = memory.location, memory.per_sigma, memory.z, memory.root
    value, first, seven, nine = memory.value, memory.first, memory.seven, memory.nine
    for e in range(BLOCK):
        value[e], first[e], seven[e], nine[e] = 0.0, 0.0, 0.0, 0.0
    for k in range(n_nodes):
        place, weight = memory.place[k], memory.weight[k]
        # One short loop after the other, of few arrays each: so they compile to vectors.
        for e in range(BLOCK):
            z[e] = (place[e] - m[e]) * per_sigma[e]
            root[e] = _inverse_root(1.0 + 0.25 * z[e] * z[e])
        for e in range(BLOCK):
            s = root[e] * root[e]
            value[e] += weight[e] * (s * s * root[e])
        if slopes:
            for e in range(BLOCK):
                s = root[e] * root[e]
                first[e] += weight[e] * (s * s * s * root[e]) * z[e]
            for e in range(BLOCK):
                s = root[e] * root[e]
                seven[e] += weight[e] * (s * s * s * root[e])
            for e in range(BLOCK):
                s = root[e] * root[e]
                nine[e] += weight[e] * (s * s * s * s * root[e])


@kernel(inner=True, forceinline=True)
def _inverse_root(x: float) -> float:
    """1 / √x to the last digit but one, by two steps of Newton's from one of single precision."""
    y = np.float64(np.float32(1.0) / np.sqrt(np.float32(x)))
    half = 0.5 * x
    y *= 1.5 - half * y * y
    y *= 1.5 - half * y * y
    return y
