"""Values at any place on a few axes, from those at the points of a star.

A star has a centre, more points along each axis (its arms), two for each pair of axes, and perhaps
points `beside` the arms; how it interpolates is in docs/theory/likelihood.md, "Stars". Of the two
bends (second differences) that make a cubic of a line, neither counts as more than `MOST_BENT`
times the other; between two points the cubic leaves their range only where the points beside them
say that it turns there.
"""

from bisect import bisect_left
from collections.abc import Sequence
from itertools import accumulate, combinations
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.kernels import kernel

ALIKE = 0.5
"""Reach of what a point beside the arms says, in half lengths of them."""
MOST_BENT = 4.0
"""How many times one bend of a cubic may be the other; those of a cubic on even points from its
middle on are 1 to 3 times."""


class Line(NamedTuple):
    """Neighbouring points of an arm, from index `first`, and what interpolates between them.

    `linear` `[n_points]` are weights of the points; `bends` `[2, n_points]` give two second
    differences of them. The cubic is the line plus `pulls` `[2]` times these. The value lies
    between points `cell` and the next.
    """

    first: int
    cell: int
    linear: Floats
    bends: Floats
    pulls: Floats


def line_weights(points: Sequence[float], value: float) -> Line:
    """The line through up to four neighbours, among rising points, of a value; one if it is met."""
    right = min(max(bisect_left(points, value), 1), len(points) - 1)
    for k in (right - 1, right):
        if points[k] == value:
            return Line(k, 0, np.ones(1), np.zeros((2, 1)), np.zeros(2))
    width = min(4, len(points))
    first = min(max(right - width // 2, 0), len(points) - width)
    x, cell = points[first : first + width], right - 1 - first
    share = (value - x[cell]) / (x[cell + 1] - x[cell])
    linear, bends, pulls = np.zeros(width), np.zeros((2, width)), np.zeros(2)
    linear[cell], linear[cell + 1] = 1.0 - share, share
    if width > 2:
        for bend, k in zip(bends, (0, width - 3), strict=True):
            a, b, c = x[k : k + 3]
            bend[k : k + 3] = (
                1.0 / ((a - b) * (a - c)),
                1.0 / ((b - a) * (b - c)),
                1.0 / ((c - a) * (c - b)),
            )
        # By Neville: the quadratics of the two bends, mixed.
        part = 0.5
        if width == 4:
            part = (value - x[(2, 0, 1)[cell]]) / (x[3] - x[0]) + (cell == 2)
        pulls[:] = (value - x[cell]) * (value - x[cell + 1]) * np.array([1.0 - part, part])
    return Line(first, cell, linear, bends, pulls)


@kernel
def along(line: Line, values: Floats) -> Floats:
    """Values `[n_points, n]` at the points of a line, interpolated: `[n]`."""
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


class StarPlace(NamedTuple):
    """A place on a star: its distance from the centre `[n_axes]`, and of each axis its line.

    With the points of the star that the line goes through. Beyond the reach of an arm its end
    counts. `shares` `[n_beside]` are those of what the points beside the arms say.
    """

    moved: Floats
    lines: list[tuple[Line, Ints]]
    shares: Floats


class Star:
    """`arms`: points along each axis, the centre first; `points` `[n_points, n_axes]` are all.

    The last are those `beside` the arms `[n_beside, n_axes]`.
    """

    def __init__(self, arms: Sequence[tuple[float, ...]], beside: Floats | None = None) -> None:
        self.arms = [np.array(points) for points in arms]
        self._rising = [sorted(points) for points in arms]
        first = list(accumulate((len(points) - 1 for points in arms), initial=1))
        # Points of the arms in rising order, as points of the star.
        orders = [np.argsort(points) for points in self.arms]
        starts = zip(orders, first[:-1], strict=True)
        self._of_arm = [np.where(order == 0, 0, start + order - 1) for order, start in starts]
        self._first = first
        self._pairs = [
            (a, b, i, j)
            for a, b in combinations(range(len(arms)), 2)
            for i, j in zip(_halfway(self.arms[a]), _halfway(self.arms[b]), strict=True)
        ]
        centre = np.array([points[0] for points in arms])
        self.points = np.tile(centre, (first[-1] + len(self._pairs), 1))
        for axis, points in enumerate(self.arms):
            self.points[first[axis] : first[axis + 1], axis] = points[1:]
        for at, (a, b, i, j) in zip(self.points[first[-1] :], self._pairs, strict=True):
            at[a], at[b] = self.arms[a][i], self.arms[b][j]
        self._n_own = len(self.points)
        self._scale = np.array([0.5 * np.ptp(points) for points in self.arms])
        self._kriged: Floats = np.empty((self._n_own, 0))
        if beside is not None and len(beside):
            self.points = np.concatenate([self.points, beside])
            covariance = self._alike(self.points) + 1e-9 * np.eye(len(self.points))
            self._kriged = np.linalg.inv(covariance)[:, self._n_own :].astype(np.float64)
        own = [self._own_mixing(self.place(at).lines) for at in self.points[self._n_own :]]
        self._own_of_beside = np.array(own).reshape(-1, self._n_own)

    def _alike(self, places: Floats) -> Floats:
        """How alike a star is off at places `[n, n_axes]` and its points, `[n, n_points]`."""
        apart = (places[:, None] - self.points) / self._scale
        return np.asarray(np.exp(-np.sqrt(np.sum(apart**2, axis=-1)) / ALIKE))

    def place(self, values: Sequence[float] | Floats) -> StarPlace:
        """The place with these values `[n_axes]`."""
        at, lines = np.empty(len(self.arms)), []
        for axis, (rising, of_star) in enumerate(zip(self._rising, self._of_arm, strict=True)):
            at[axis] = value = min(max(float(values[axis]), rising[0]), rising[-1])
            line = line_weights(rising, value)
            lines.append((line, of_star[line.first : line.first + len(line.linear)]))
        beside = self._kriged.shape[1] > 0
        shares = self._alike(at[None])[0] @ self._kriged if beside else np.empty(0)
        return StarPlace(at - self.points[0], lines, shares)

    def mixing(self, place: StarPlace) -> Floats:
        """Weights of the points `[n_points]` that mix their values linearly along each arm."""
        own = self._own_mixing(place.lines) - place.shares @ self._own_of_beside
        return np.concatenate([own, place.shares])

    def _own_mixing(self, lines: list[tuple[Line, Ints]]) -> Floats:
        weights = np.zeros(self._n_own)
        weights[0] = 1.0 - len(self.arms)
        for line, points in lines:
            weights[points] += line.linear
        return weights

    def relative(self, values: Floats) -> Floats:
        """Values at the points `[n_points, n]` as `between` has them.

        Those beside the arms, less what the arms say of them.
        """
        result = values.copy()
        for k in range(self._n_own, len(values)):
            by_arms = self.place(self.points[k])._replace(
                shares=np.zeros(len(values) - self._n_own)
            )
            result[k] -= self.between(by_arms, values)
        return result

    def between(self, place: StarPlace, values: Floats) -> Floats:
        """Values at the points `[n_points, n]`, `relative`, interpolated at a place: `[n]`.

        By limited cubics along each arm, and products of two axes: what a pair's points have
        beyond the sum of both arms.
        """
        result: Floats = values[0] + place.shares @ values[self._n_own :]
        for line, points in place.lines:
            result += along(line, values[points]) - values[0]
        for pair, (a, b, i, j) in enumerate(self._pairs, start=self._first[-1]):
            share = 0.5 * place.moved[a] * place.moved[b]
            share /= (self.arms[a][i] - self.arms[a][0]) * (self.arms[b][j] - self.arms[b][0])
            beside = values[self._first[a] + i - 1] + values[self._first[b] + j - 1] - values[0]
            result += share * (values[pair] - beside)
        return result


def _halfway(points: Floats) -> tuple[int, int]:
    """Which points of an arm lie about halfway to both its ends (or to one, for two)."""
    away = points - points[0]
    ends = [end for end in (np.min(away), np.max(away)) if end != 0.0]
    halves = (ends[0] / 2, ends[-1] / 2) if len(ends) == 2 else (ends[0] / 2, ends[0])
    first, second = (int(np.argmin(np.abs(away[1:] - half))) + 1 for half in halves)
    return first, second
