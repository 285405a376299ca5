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
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
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


def packed(nodes: Nodes, in_sight: bool) -> Nodes:
    """The nodes without those that are not used: place and weight of all events, `[n_used]`.

    Most events use few, a vague one many. Where all is `in_sight`, nothing is kept of what is seen.
    """
    used = _is_used(nodes.used)
    seen = np.zeros_like(used) if in_sight else used
    return nodes._replace(
        place=nodes.place[used],
        weight=nodes.weight[used],
        seen_place=nodes.seen_place[seen],
        seen_weight=nodes.seen_weight[seen],
    )


def unpacked(nodes: Nodes) -> Nodes:
    """The nodes of `packed`, `[n_events, n_nodes]` again."""
    used = _is_used(nodes.used)

    def spread(packed: Floats) -> Floats:
        whole = np.zeros(used.shape)
        if len(packed):
            whole[used] = packed
        return whole

    return nodes._replace(
        place=spread(nodes.place),
        weight=spread(nodes.weight),
        seen_place=spread(nodes.seen_place),
        seen_weight=spread(nodes.seen_weight),
    )


def _is_used(used: Ints) -> NDArray[np.bool_]:
    return np.asarray(np.arange(np.max(used, initial=0)) < used[:, None])


def stack(nodes: Sequence[Nodes]) -> Nodes:
    """Packed nodes of several grid points, every array with these as its first axis."""
    return Nodes(*(np.stack(arrays) for arrays in zip(*nodes, strict=True)))


def interpolated(cubic: Floats, linear: Floats, corners: Nodes) -> Nodes:
    """Nodes at a place between the packed `corners`, with weights `[n_corners]` of each."""
    plain, used = corners.is_probability[0], corners.used[0]
    place, weight = _mix(cubic, linear, corners.place, corners.weight, plain, used)
    seen_place, seen_weight = np.zeros_like(place), np.zeros_like(place)
    has_limit = np.any(corners.has_limit, axis=0)
    if has_limit.any():
        seen_place, seen_weight = _mix(
            linear, linear, corners.seen_place, corners.seen_weight, np.ones_like(plain), used
        )
    return Nodes(
        place=place,
        weight=weight,
        used=used,
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
def _mix(cubic, linear, places, weights, plain, used):  # type: ignore[no-untyped-def]
    """Means by cubic weights, shapes about them by linear ones (`plain`: shapes alone).

    Of packed `places` and `weights` `[n_corners, n_used]`; `[n_events, n_nodes]` of both.
    """
    n_corners, n = len(cubic), len(used)
    n_nodes = 0
    for i in range(n):
        n_nodes = max(n_nodes, used[i])
    place = np.zeros((n, n_nodes))
    weight = np.zeros((n, n_nodes))
    end = 0
    for i in range(n):
        first, end = end, end + used[i]
        mean = 0.0
        means = np.zeros(n_corners)
        if not plain[i]:
            for c in range(n_corners):
                for k in range(first, end):
                    means[c] += places[c, k] * weights[c, k]
                mean += cubic[c] * means[c]
        for k in range(first, end):
            total, size, moment = 0.0, 0.0, 0.0
            for c in range(n_corners):
                share = linear[c] * weights[c, k]
                total += share
                size += abs(share)
                moment += abs(share) * (places[c, k] - means[c])
            weight[i, k - first] = total
            place[i, k - first] = mean + (moment / size if size > 0.0 else 0.0)
    return place, weight
