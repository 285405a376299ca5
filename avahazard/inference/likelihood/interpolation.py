"""Values between points along a line: cubics that do not overshoot.

At a point from which no friction reaches a record its log mass is lower by nats or hundreds, and a
cubic through it rises far above the points between which it is asked. So of the two bends (second
differences) that make a cubic of a line, neither counts as more than `MOST_BENT` times the other;
and between two points the cubic leaves their range only where the points beside them say that it
turns there.
"""

from __future__ import annotations

from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
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
