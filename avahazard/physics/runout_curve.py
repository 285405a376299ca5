"""F(μ): where the block stops as a function of friction, tabulated, looked up and turned round.

A cell of the grid of frictions over which F jumps is *discontinuous* (docs/theory/motion.md): in it
the nearer end counts, so that nothing stops where no run of the block does, and no stop is mixed
with a run beyond the profile or one held at its release. Elsewhere F is straight between the ends.
What jumps is x: elevation hardly changes where a flat reach is jumped over, and turns round on a
counter-slope. The likelihood alone (`inference.likelihood.record_nodes`) spreads records evenly
over a jump, on purpose, since real terrain and real avalanches have no such gaps.

Near some stops (`near_stops`) runs go from a first guess to both sides until they are past what is
asked for, since F falls with friction. What would be beyond is held at the last that was run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats, Ints
from avahazard.kernels import kernel
from avahazard.physics.block import LEFT_PROFILE, STOPPED, Asked, run, run_near
from avahazard.physics.cells import Cells

MU_STEP = 0.0025
"""Spacing of the friction grid where it is even, as in the paper."""
N_BELOW, N_ABOVE, GROWTH = 24, 40, 1.104967598682188
"""Cells below and above those: from 0.001 to 0.02 and from 1.6 to 3, each wider or narrower than
the next by one factor, so that F is as straight within as it is beside. All numbers of cells are
multiples of 4: every fourth friction makes a grid of the same kind."""


_EVEN = np.arange(0.02, 1.6 + MU_STEP / 2, MU_STEP)
_ABOVE = _EVEN[-1] + MU_STEP * np.cumsum(GROWTH ** np.arange(1, N_ABOVE + 1))
MU = np.concatenate([np.geomspace(0.001, _EVEN[0], N_BELOW, endpoint=False), _EVEN, _ABOVE])
"""Frictions at which runouts are tabulated, `[n_friction]`."""
EVEN = slice(N_BELOW, len(MU) - N_ABOVE)
"""Those with one spacing."""
JUMP_FACTOR = 5.0
"""A cell is a jump where the stop moves this many times as far as in the wider cell beside it."""


@dataclass(frozen=True, slots=True, eq=False)
class RunoutCurve:
    """F(μ) over `MU` of one run, `[n_friction]`, or of several, `[n_rows, n_friction]`.

    `x`, `y` are in m, `status` as in `physics.block`; where the block ran beyond the profile they
    are no stops.
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]

    def __getitem__(self, rows: Any) -> RunoutCurve:
        """The curves of these rows, or the curve of one."""
        return RunoutCurve(self.x[rows], self.y[rows], self.status[rows])

    @property
    def left(self) -> Bools:
        """Whether the block ran beyond the profile."""
        return np.asarray(self.status == LEFT_PROFILE)

    @property
    def discontinuous(self) -> Bools:
        """Cells that must not be interpolated (the rule above), `[…, n_friction - 1]`."""
        stopped, places = self.status == STOPPED, np.where(np.isfinite(self.x), self.x, 0.0)
        moving = stopped[..., 1:] & stopped[..., :-1]
        gap = np.where(moving, np.abs(np.diff(places, axis=-1)), -1.0)
        none = np.full((*gap.shape[:-1], 1), -1.0)
        padded = np.concatenate([none, gap, none], axis=-1)
        beside = np.maximum(padded[..., :-2], padded[..., 2:])
        jump = (beside >= 0.0) & (gap > JUMP_FACTOR * beside)
        return np.asarray(~moving | jump)

    @property
    def jumps(self) -> Bools:
        """Cells from one stop to the next over which F jumps, `[…, n_friction - 1]`."""
        stopped = self.status == STOPPED
        return np.asarray(self.discontinuous & stopped[..., 1:] & stopped[..., :-1])

    def at(self, mu: Floats) -> tuple[Floats, Floats, NDArray[np.int8]]:
        """x, y and status at frictions `mu` `[(n_rows,) n]`; beyond the grid its end counts."""
        cell, share = located(steps_of(mu), self.discontinuous)
        x, y = between(self.x, cell, share), between(self.y, cell, share)
        return x, y, nearest(self.status, cell, share)

    def derivative(self) -> tuple[Floats, Floats]:
        """F'(μ) at the nodes: dx/dμ and dy/dμ (m), the mean of the straight cells beside each.

        nan where there is none: within jumps, where the block left, where it was held.
        """

        def slope(values: Floats) -> Floats:
            of_cell = np.where(self.discontinuous, np.nan, np.diff(values) / np.diff(MU))
            none = np.full((*of_cell.shape[:-1], 1), np.nan)
            below = np.concatenate([none, of_cell], axis=-1)
            above = np.concatenate([of_cell, none], axis=-1)
            both = np.where(np.isnan(below), above, 0.5 * (below + above))
            return np.where(np.isnan(above), below, both)

        return slope(self.x), slope(self.y)


def steps_of(mu: Floats) -> Floats:
    """Frictions `mu` in steps from the first node of `MU`; beyond the grid its end counts."""
    return np.asarray(np.interp(mu, MU, np.arange(len(MU))))


def located(steps: Floats, discontinuous: Bools) -> tuple[NDArray[np.int64], Floats]:
    """Cell of each place `[…, n]` on the grid, and the share of its upper end: 0 or 1 at a jump."""
    n_cells = discontinuous.shape[-1]
    cell = np.minimum(steps.astype(np.int64), n_cells - 1)
    share = steps - cell
    flat = np.take_along_axis(discontinuous, cell, axis=-1)
    return cell, np.where(flat, share >= 0.5, share)


def between(values: Floats, cell: NDArray[np.int64], share: Floats) -> Floats:
    """Values of the curve's nodes `[…, n_friction]` at what `located` found, `[…, n]`."""
    low = np.take_along_axis(values, cell, axis=-1)
    high = np.take_along_axis(values, cell + 1, axis=-1)
    # Not a plain sum of shares: nan of the end that does not count must not spill over.
    mixed = low * (1.0 - share) + high * share
    return np.where(share == 0.0, low, np.where(share == 1.0, high, mixed))


def nearest(status: NDArray[np.int8], cell: NDArray[np.int64], share: Floats) -> NDArray[np.int8]:
    """Status of the nearer node at what `located` found, `[…, n]`."""
    return np.take_along_axis(status, cell + (share >= 0.5), axis=-1)


@kernel(forceinline=True)
def inverse(values, discontinuous, level):  # type: ignore[no-untyped-def]
    """Friction under which `values` `[n_friction]` over `MU` exceed a level.

    `values` fall, as stops do; they are inf where the profile was left. The friction is 0 where
    none exceeds the level, inf where all do, and the middle of a cell with a jump.
    """
    n, most = 0, len(values)
    while n < most:
        middle = (n + most) // 2
        if values[middle] > level:
            n = middle + 1
        else:
            most = middle
    if n == 0:
        return 0.0
    if n == len(values):
        return np.inf
    above, under = values[n - 1], values[n]
    part = (above - level) / (above - under)
    if discontinuous[n - 1] or not np.isfinite(part):
        part = 0.5
    return MU[n - 1] + part * (MU[n] - MU[n - 1])


def pieces(curve: RunoutCurve) -> tuple[Floats, NDArray[np.int8]]:
    """Curves in straight pieces of half a cell each, and their status, for `piece_at`.

    They are `[…, 2 n_friction, 4]`, `[…, 2 n_friction]`: in steps t of the grid, piece k holds for
    k - 1 ≤ 2t < k; the first and the last hold for everything below and above the grid, at the
    value of the end node. A row is (x at t = 0, dx/dt, y at t = 0, dy/dt). Left of profile is
    x = +inf, y = -inf.
    """
    flat, cell = ~curve.discontinuous, np.arange(curve.status.shape[-1] - 1)
    # Each node owns the half cells on both its sides.
    status = np.repeat(curve.status, 2, axis=-1)
    rows = np.zeros((*status.shape, 4))
    for column, stop, far in ((0, curve.x, np.inf), (2, curve.y, -np.inf)):
        value = np.where(curve.left, far, stop)
        with np.errstate(invalid="ignore"):
            slope = np.where(flat, np.diff(value), 0.0)
        start = value[..., :-1] - slope * cell
        rows[..., column] = np.repeat(value, 2, axis=-1)
        rows[..., 1:-1:2, column] = start
        rows[..., 2::2, column] = np.where(flat, start, value[..., 1:])
        rows[..., 1:-1:2, column + 1] = rows[..., 2::2, column + 1] = slope
    return rows, status


LOW, HIGH = float(MU[EVEN.start]), float(MU[EVEN.stop - 1])
STEPS_PER_MU = (EVEN.stop - 1 - EVEN.start) / (HIGH - LOW)
"""Ends of the even frictions, and how many of their steps there are to a unit of friction."""


@kernel(forceinline=True)
def piece_at(rows, mu):  # type: ignore[no-untyped-def]
    """Row of the piece that holds μ, and μ in steps of the grid."""
    if LOW <= mu <= HIGH:
        t = N_BELOW + (mu - LOW) * STEPS_PER_MU
    else:
        j = min(max(np.searchsorted(MU, mu) - 1, 0), len(MU) - 2)
        t = j + (mu - MU[j]) / (MU[j + 1] - MU[j])
    return int(min(max(2.0 * t + 1.0, 0.0), len(rows) - 1.0)), t


COARSE = 4
COARSE_MU = np.ascontiguousarray(MU[::COARSE])
"""Where resistance depends on speed, and a run costs ten times as much, every fourth friction is
run for whole tables."""
MARGIN, WIDTH, SLOW_MARGIN, SLOW_WIDTH = 12, 32, 4, 16
"""Frictions run beyond the stops asked for, by which a jump shows, and at once; the last two where
each costs by itself."""


class NearStops(NamedTuple):
    """`curve` `[n_starts, n_friction]`, run from `first` to before `end`, and held beyond."""

    curve: RunoutCurve
    first: Ints
    end: Ints


def tabulate(cells: Cells, starts: NDArray[np.int64]) -> RunoutCurve:
    """F(μ) from each start node `[n_starts]`.

    Where the block ran beyond the profile, x and y are nan; where it was not released, the release.
    """
    if not cells.speed_dependent:
        return RunoutCurve(*run(cells, starts, MU)[:3])
    return filled(RunoutCurve(*run(cells, starts, COARSE_MU)[:3]))


def near_stops(cells: Cells, starts: NDArray[np.int64], asked: Asked) -> NearStops:
    """F(μ) from each start node `[n_starts]` near what is asked, the same for every `middle`."""
    at_once = (SLOW_WIDTH, SLOW_MARGIN) if cells.speed_dependent else (WIDTH, MARGIN)
    x, y, status, _, first, end = run_near(cells, starts, MU, *asked, *at_once)
    return NearStops(RunoutCurve(x, y, status), first, end)


def as_near_stops(curve: RunoutCurve) -> NearStops:
    """A whole table `[n_starts, n_friction]`, as if every stop had been asked for."""
    n_starts, n = curve.x.shape
    return NearStops(curve, np.zeros(n_starts, np.int64), np.full(n_starts, n))


def refined(values: Floats, smooth: Bools) -> Floats:
    """Values `[…, n - 1, COARSE]` from each of n nodes on to the next, of `values` `[…, n]` there.

    By the cubic through the four nodes about them, within the range of the nearer two; straight
    where they are not `smooth` `[…, n - 1]`.
    """
    share = np.arange(COARSE) / COARSE
    low, high = values[..., :-1, None], values[..., 1:, None]
    bend = np.zeros(values.shape)
    bend[..., 1:-1] = np.diff(values, 2)
    curved = bend[..., :-1, None] * (2.0 - share) + bend[..., 1:, None] * (1.0 + share)
    curved = np.where(smooth[..., None], share * (share - 1.0) * curved / 6.0, 0.0)
    found = low + share * (high - low) + curved
    return np.clip(found, np.minimum(low, high), np.maximum(low, high))


def filled(coarse: RunoutCurve) -> RunoutCurve:
    """Curves `[n_rows, n_friction]` over `MU` from those at every `COARSE`-th friction (`refined`).

    Straight beside a jump, within which the nearer end counts.
    """
    discontinuous, n_rows = coarse.discontinuous, len(coarse.x)
    near = (np.arange(COARSE * discontinuous.shape[1] + 1) + COARSE // 2) // COARSE
    apart = np.pad(discontinuous, ((0, 0), (1, 1)), constant_values=True)
    smooth = ~(apart[:, :-2] | apart[:, 1:-1] | apart[:, 2:])

    def fine(values: Floats) -> Floats:
        nearest = values[:, near]
        inside = nearest[:, :-1].reshape(*smooth.shape, COARSE)
        between = np.where(discontinuous[..., None], inside, refined(values, smooth))
        nearest[:, :-1] = between.reshape(n_rows, -1)
        return nearest

    return RunoutCurve(fine(coarse.x), fine(coarse.y), coarse.status[:, near])
