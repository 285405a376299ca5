"""Nodes between the grid points of the parameters that shape the tables.

What changes smoothly with such a parameter is where a likelihood lies and how much it holds: its
mean and log mass are interpolated by cubics. Its shape is mixed linearly, so that weights stay
positive.

At a grid point from which no friction reaches a record its log mass is lower by nats or hundreds,
and a cubic through it rises far above the points between which it is asked. So of the two bends
(second differences) that make a cubic of a line, neither counts as more than `MOST_BENT` times the
other; and between two points the cubic leaves their range only where the points beside them say
that it turns there.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.kernels import kernel

MOST_BENT = 4.0
"""How many times one bend of a cubic may be the other; those of a cubic on even points from its
middle on are 1 to 3 times."""


class Line(NamedTuple):
    """Neighbouring points of a grid, from index `first`, and what interpolates between them.

    `linear` `[n_points]` are weights of the points; `bends` `[2, n_points]` give two second
    differences of them. The cubic is the line plus `pulls` `[2]` times these. The value lies
    between points `cell` and the next.
    """

    first: int
    cell: int
    linear: Floats
    bends: Floats
    pulls: Floats


def line_weights(grid: tuple[float, ...], value: float) -> Line:
    """The line through up to four neighbours of the value; through one if it is met."""
    right = min(max(bisect_left(grid, value), 1), len(grid) - 1)
    for k in (right - 1, right):
        if grid[k] == value:
            return Line(k, 0, np.ones(1), np.zeros((2, 1)), np.zeros(2))
    width = min(4, len(grid))
    first = min(max(right - width // 2, 0), len(grid) - width)
    x, cell = np.array(grid[first : first + width]), right - 1 - first
    share = (value - x[cell]) / (x[cell + 1] - x[cell])
    linear, bends, pulls = np.zeros(width), np.zeros((2, width)), np.zeros(2)
    linear[cell], linear[cell + 1] = 1.0 - share, share
    if width > 2:
        for bend, k in zip(bends, (0, width - 3), strict=True):
            bend[k : k + 3] = _second_difference(x[k : k + 3])
        # By Neville: the quadratics of the two bends, mixed.
        part = 0.5
        if width == 4:
            part = (value - x[(2, 0, 1)[cell]]) / (x[3] - x[0]) + (cell == 2)
        pulls[:] = (value - x[cell]) * (value - x[cell + 1]) * np.array([1.0 - part, part])
    return Line(first, cell, linear, bends, pulls)


def _second_difference(x: Floats) -> tuple[float, float, float]:
    """Weights of the second divided difference at three points."""
    a, b, c = x.tolist()
    return 1.0 / ((a - b) * (a - c)), 1.0 / ((b - a) * (b - c)), 1.0 / ((c - a) * (c - b))


def along(line: Line, values: Floats) -> Floats:
    """Values `[n_points, …]` at the points of a line, interpolated: `[…]`."""
    flat = np.ascontiguousarray(values).reshape(len(values), -1)
    return np.asarray(_along(line, flat).reshape(values.shape[1:]))


@kernel
def _along(line: Line, values: Floats) -> Floats:
    """The same of values `[n_points, n]`: `[n]`."""
    n_points, n = values.shape
    cell = line.cell
    inside = 0 < cell < n_points - 2
    found = np.empty(n)
    for i in range(n):
        straight, one, other = 0.0, 0.0, 0.0
        for k in range(n_points):
            straight += line.linear[k] * values[k, i]
            one += line.bends[0, k] * values[k, i]
            other += line.bends[1, k] * values[k, i]
        most = MOST_BENT * min(abs(one), abs(other))
        one, other = min(max(one, -most), most), min(max(other, -most), most)
        found[i] = straight + line.pulls[0] * one + line.pulls[1] * other
        if n_points < 3:
            continue
        left, right = values[cell, i], values[cell + 1, i]
        turns = inside and (left - values[cell - 1, i]) * (values[cell + 2, i] - right) < 0.0
        if not turns:
            found[i] = min(max(found[i], min(left, right)), max(left, right))
    return found


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


def interpolated(lines: Sequence[Line], corners: Corners) -> Nodes:
    """Nodes between the `corners`, all points of these lines (those of the last change first)."""
    nodes = corners.nodes
    linear = reduce(np.multiply.outer, [line.linear for line in lines]).ravel()
    plain, used = nodes.is_probability[0], nodes.used[0]
    # Most corners have a part in means alone.
    near = np.flatnonzero(linear)
    share = linear[near]
    about = np.where(plain, 0.0, corners.mean[near])
    mean = np.where(plain, 0.0, _along_all(lines, corners.mean))
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
        log_scale=_along_all(lines, nodes.log_scale),
        is_probability=plain,
        floor=share @ nodes.floor[near],
        seen_place=seen_place,
        seen_weight=seen_weight,
        seen_floor=share @ nodes.seen_floor[near],
        has_limit=has_limit,
        log_wrong=nodes.log_wrong[0],
    )


def _along_all(lines: Sequence[Line], values: Floats) -> Floats:
    """Values `[n_corners, n_events]` of all points of the lines, interpolated: `[n_events]`."""
    values = values.reshape(*(len(line.linear) for line in lines), -1)
    for line in lines:
        values = along(line, values)
    return values


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
