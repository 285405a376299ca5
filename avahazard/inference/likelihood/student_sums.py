"""Sums over the nodes of records of Student's density of friction, with their derivatives.

Many events go through one step after the other, side by side in vectors. With z = (ν - m) / σ and
a shape s = 1 / (1 + z²/4), the density is STUDENT_PEAK s^(5/2) / σ, and all its derivatives are
sums of s^(5/2), s^(7/2), s^(9/2) and z s^(7/2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.model.friction_scatter import STUDENT_PEAK, STUDENT_PULL
from avahazard.kernels import kernel

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
    many = (n_nodes, BLOCK)
    return BlockMemory(
        np.zeros(many),
        np.zeros(many),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
        np.zeros(BLOCK),
    )


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
