"""Nodes between the grid points of the parameters that shape the tables.

What changes smoothly with such a parameter is where a likelihood lies and how much it holds: its
mean and log mass are interpolated by cubics. Its shape is mixed linearly, so that weights stay
positive.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.kernels import kernel


class Line(NamedTuple):
    """Neighbouring points of a grid, from index `first`, with their weights `[n_points]`."""

    first: int
    cubic: tuple[float, ...]
    linear: tuple[float, ...]


def line_weights(grid: tuple[float, ...], value: float) -> Line:
    """Weights of up to four neighbours for cubic and linear interpolation; of one if it is met."""
    right = min(max(bisect_left(grid, value), 1), len(grid) - 1)
    for k in (right - 1, right):
        if grid[k] == value:
            return Line(k, (1.0,), (1.0,))
    width = min(4, len(grid))
    first = min(max(right - width // 2, 0), len(grid) - width)
    share = (value - grid[right - 1]) / (grid[right] - grid[right - 1])
    linear = {right - 1: 1.0 - share, right: share}
    window = range(first, first + width)
    cubic = tuple(
        math.prod((value - grid[j]) / (grid[k] - grid[j]) for j in window if j != k) for k in window
    )
    return Line(first, cubic, tuple(linear.get(k, 0.0) for k in window))


def stack(nodes: Sequence[Nodes]) -> Nodes:
    """Nodes of several grid points, every array with these as its first axis."""
    return Nodes(*(np.stack(arrays) for arrays in zip(*nodes, strict=True)))


def interpolated(cubic: Floats, linear: Floats, corners: Nodes) -> Nodes:
    """Nodes at a place between the `corners`, with weights `[n_corners]` of each."""
    plain = corners.is_probability[0]
    place, weight = _mix(cubic, linear, corners.place, corners.weight, plain)
    has_limit = np.any(corners.has_limit, axis=0)
    seen_place, seen_weight = corners.seen_place[0], corners.seen_weight[0]
    if has_limit.any():
        seen_place, seen_weight = _mix(
            linear, linear, corners.seen_place, corners.seen_weight, np.ones_like(plain)
        )
    return Nodes(
        place=place,
        weight=weight,
        used=corners.used[0],
        tail_place=corners.tail_place[0],
        tail=np.tensordot(linear, corners.tail, 1),
        log_scale=cubic @ corners.log_scale,
        is_probability=plain,
        floor=linear @ corners.floor,
        seen_place=seen_place,
        seen_weight=seen_weight,
        seen_floor=linear @ corners.seen_floor,
        has_limit=has_limit,
        log_wrong=corners.log_wrong[0],
    )


@kernel
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
