"""Nodes between the grid points of the parameters that shape the tables.

What changes smoothly with such a parameter is where a bump lies and how much it holds: its mean
and log mass are interpolated by cubics. Its shape is mixed linearly, so that weights stay positive.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.inference.nodes import Nodes

Floats = NDArray[np.float64]


class Corner(NamedTuple):
    """One grid point near the wanted place: its weight in cubic and in linear interpolation."""

    cubic: float
    linear: float
    place: tuple[int, ...]


def line_weights(grid: tuple[float, ...], value: float) -> list[tuple[float, float, int]]:
    """Cubic and linear weights on up to four neighbouring points of a grid."""
    right = min(max(bisect_left(grid, value), 1), len(grid) - 1)
    for k in (right - 1, right):
        if grid[k] == value:
            return [(1.0, 1.0, k)]
    width = min(4, len(grid))
    first = min(max(right - width // 2, 0), len(grid) - width)
    share = (value - grid[right - 1]) / (grid[right] - grid[right - 1])
    linear = {right - 1: 1.0 - share, right: share}
    window = range(first, first + width)
    weights = []
    for k in window:
        cubic = math.prod((value - grid[j]) / (grid[k] - grid[j]) for j in window if j != k)
        weights.append((cubic, linear.get(k, 0.0), k))
    return weights


def blend(corners: Sequence[Corner], nodes: Sequence[Nodes]) -> Nodes:
    """Nodes at a place between the corners; exactly those of a corner that is met."""
    if len(nodes) == 1:
        return nodes[0]
    cubic = np.array([c.cubic for c in corners])
    linear = np.array([c.linear for c in corners])
    place, weight = _mix(
        cubic,
        linear,
        np.stack([n.place for n in nodes]),
        np.stack([n.weight for n in nodes]),
        nodes[0].is_probability,
    )
    seen_place, seen_weight = _mix(
        linear,
        linear,
        np.stack([n.seen_place for n in nodes]),
        np.stack([n.seen_weight for n in nodes]),
        np.ones(len(place), dtype=np.bool_),
    )
    return Nodes(
        place=place,
        weight=weight,
        log_scale=cubic @ np.stack([n.log_scale for n in nodes]),
        is_probability=nodes[0].is_probability,
        floor=linear @ np.stack([n.floor for n in nodes]),
        seen_place=seen_place,
        seen_weight=seen_weight,
        seen_floor=linear @ np.stack([n.seen_floor for n in nodes]),
        has_limit=np.any([n.has_limit for n in nodes], axis=0),
    )


@njit(cache=True, nogil=True)
def _mix(cubic, linear, places, weights, plain):  # type: ignore[no-untyped-def]
    """Means by cubic weights, shapes about them by linear ones (`plain`: shapes alone)."""
    n_corners, n, n_nodes = places.shape
    place = np.zeros((n, n_nodes))
    weight = np.zeros((n, n_nodes))
    for i in range(n):
        mean = 0.0
        means = np.zeros(n_corners)
        if not plain[i]:
            for c in range(n_corners):
                for k in range(n_nodes):
                    means[c] += places[c, i, k] * weights[c, i, k]
                mean += cubic[c] * means[c]
        for k in range(n_nodes):
            total, size, moment = 0.0, 0.0, 0.0
            for c in range(n_corners):
                share = linear[c] * weights[c, i, k]
                total += share
                size += abs(share)
                moment += abs(share) * (places[c, i, k] - means[c])
            weight[i, k] = total
            place[i, k] = mean + (moment / size if size > 0.0 else 0.0)
    return place, weight
