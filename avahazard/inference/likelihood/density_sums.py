"""Sums over the nodes of a record of the density of friction, with their derivatives.

All nodes of all volumes of an event go through one step after the other, in vectors.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.exponentials import ExpMemory, exp_memory, exponentials
from avahazard.inference.model.friction_scatter import (
    NORMAL_PEAK,
    STUDENT_PEAK,
    STUDENT_PULL,
    student_shape,
)
from avahazard.kernels import kernel

LANES = 8
"""Numbers of the widest registers: the nodes are filled up to a multiple of these."""


class SumMemory(NamedTuple):
    """Working memory for the nodes of one event, volume after volume."""

    z: Floats
    density: Floats
    shape: Floats
    exp: ExpMemory


@kernel
def sum_memory(n: int) -> SumMemory:
    """Working memory for n nodes."""
    n += LANES
    return SumMemory(np.zeros(n), np.zeros(n), np.zeros(n), exp_memory(n))


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
            out[q, 1:] = 0.0


@kernel
def student_sums(place, weight, location, scatter, slopes, memory, out):  # type: ignore[no-untyped-def]
    """The same for Student's t, without a lift."""
    z, density, shapes = memory.z, memory.density, memory.shape
    n = len(place)
    for q in range(len(location)):
        sigma, m = scatter[q], location[q]
        for k in range(n):
            z[q * n + k] = (place[k] - m) / sigma
    for k in range(_filled(len(location) * n)):
        shape = student_shape(z[k] * z[k])
        shapes[k] = shape
        density[k] = STUDENT_PEAK * shape * shape * math.sqrt(shape)
    for q in range(len(location)):
        sigma = scatter[q]
        value, first, by_scatter, second = 0.0, 0.0, 0.0, 0.0
        for k in range(n):
            a = weight[k] * density[q * n + k]
            value += a
            if slopes:
                shape, place_z = shapes[q * n + k], z[q * n + k]
                pull = STUDENT_PULL * place_z * shape
                first += a * pull
                second += a * (1.4 * pull * pull - STUDENT_PULL * shape)
                by_scatter += a * (place_z * pull - 1.0)
        out[q, 0] = value / sigma
        if slopes:
            out[q, 1] = first / (sigma * sigma)
            out[q, 2] = by_scatter / sigma
            out[q, 3] = second / (sigma * sigma * sigma)
        else:
            out[q, 1:] = 0.0
