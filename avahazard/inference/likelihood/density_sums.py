"""Sums over the nodes of a record of a normal density of friction, with their derivatives.

All nodes of all volumes of an event go through one step after the other, in vectors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.exponentials import ExpMemory, exp_memory, exponentials
from avahazard.inference.model.friction_scatter import NORMAL_PEAK
from avahazard.kernels import kernel

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
