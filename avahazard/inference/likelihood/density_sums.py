"""Sums over nodes of a density of friction, with derivatives, in loops that compile to vectors.

Normal: exp x by x = n log 2 + r with a whole n and |r| ≤ log(2) / 2; exp r is its Taylor series to
r^12, exact to the last digit but one, and 2^n is written into the bits of a float. Student's: with
z = (ν - m) / σ and a shape s = 1 / (1 + z²/4) the density is STUDENT_PEAK s^(5/2) / σ.
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
