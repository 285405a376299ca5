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


class Corners(NamedTuple):
    """Packed `nodes` of several grid points, every array with these as its first axis.

    `mean` `[n_corners, n_events]` is the mean place of each event's nodes.
    """

    nodes: Nodes
    mean: Floats

    @property
    def nbytes(self) -> int:
        """Memory of all arrays."""
        return self.mean.nbytes + sum(part.nbytes for part in self.nodes)


def stack(nodes: Sequence[Nodes]) -> Corners:
    """Packed nodes of several grid points side by side."""
    whole = Nodes(*(np.stack(arrays) for arrays in zip(*nodes, strict=True)))
    return Corners(whole, _means(whole.place, whole.weight, whole.used[0]))


def interpolated(cubic: Floats, linear: Floats, corners: Corners) -> Nodes:
    """Nodes at a place between the `corners`, with weights `[n_corners]` of each."""
    nodes = corners.nodes
    plain, used = nodes.is_probability[0], nodes.used[0]
    # Most corners have a part in means alone.
    near = np.flatnonzero(linear)
    share = linear[near]
    about = np.where(plain, 0.0, corners.mean[near])
    mean = np.where(plain, 0.0, cubic @ corners.mean)
    place, weight = _mix(share, near, nodes.place, nodes.weight, about, mean, used)
    seen_place, seen_weight = np.zeros_like(place), np.zeros_like(place)
    has_limit = np.any(nodes.has_limit, axis=0)
    if has_limit.any():
        nothing = np.zeros_like(about), np.zeros_like(mean)
        seen_place, seen_weight = _mix(
            share, near, nodes.seen_place, nodes.seen_weight, *nothing, used
        )
    return Nodes(
        place=place,
        weight=weight,
        used=used,
        tail_place=nodes.tail_place[0],
        tail=np.tensordot(share, nodes.tail[near], 1),
        log_scale=cubic @ nodes.log_scale,
        is_probability=plain,
        floor=share @ nodes.floor[near],
        seen_place=seen_place,
        seen_weight=seen_weight,
        seen_floor=share @ nodes.seen_floor[near],
        has_limit=has_limit,
        log_wrong=nodes.log_wrong[0],
    )


@kernel
def _means(places, weights, used):  # type: ignore[no-untyped-def]
    """Mean place of each event's nodes, packed `[n_corners, n_used]`: `[n_corners, n_events]`."""
    n_corners, n = len(places), len(used)
    means = np.zeros((n_corners, n))
    for c in range(n_corners):
        k = 0
        for i in range(n):
            for _ in range(used[i]):
                means[c, i] += places[c, k] * weights[c, k]
                k += 1
    return means


@kernel
def _mix(share, near, places, weights, about, mean, used):  # type: ignore[no-untyped-def]
    """Shapes of the corners `near`, mixed by their `share`, about the `mean` `[n_events]`.

    Those of packed `places` and `weights` `[n_corners, n_used]` are `about` `[n_near, n_events]`.
    Returns `[n_events, n_nodes]` of both.
    """
    n = len(used)
    n_nodes = 0
    for i in range(n):
        n_nodes = max(n_nodes, used[i])
    place = np.zeros((n, n_nodes))
    weight = np.zeros((n, n_nodes))
    end = 0
    for i in range(n):
        first, end = end, end + used[i]
        for k in range(first, end):
            total, size, moment = 0.0, 0.0, 0.0
            for c in range(len(near)):
                part = share[c] * weights[near[c], k]
                total += part
                size += abs(part)
                moment += abs(part) * (places[near[c], k] - about[c, i])
            weight[i, k - first] = total
            place[i, k - first] = mean[i] + (moment / size if size > 0.0 else 0.0)
    return place, weight
