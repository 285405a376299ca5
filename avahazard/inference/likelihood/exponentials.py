"""exp and log of many numbers at once, in a form that compiles to vectors.

x = n log 2 + r with a whole n and |r| ≤ log(2) / 2; exp r is its Taylor series to r^12, exact to
the last digit but one, and 2^n is written into the bits of a float. log takes n from there: what is
left, m, lies between √½ and √2, and log m = 2 artanh((m - 1) / (m + 1)) by its series.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
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
