"""F(μ): where the block stops as a function of friction, tabulated, looked up and turned round.

**Jumps.** On stepped terrain F jumps: no friction stops the block between two places. One rule for
all that looks up a stop: a cell of the grid of frictions is *broken* where its ends differ in
status, or where x, the place of the stop, moves more than `JUMP_FACTOR` times as far as over the
wider of the cells beside it (at all, where it rests over these). In a broken cell the nearer end
counts: nothing stops where no run of the block does, and no stop is mixed with a run beyond the
profile or was held at its release. Everywhere else F is straight between the ends. The steps of a
smooth F, however steep, change by less than that factor from one cell to the next; a jump stands
out from both (two of one size side by side do not). The rule goes by x, since elevation hardly
changes where a flat reach is jumped over, and turns round on a counter-slope.

The likelihood alone (`inference.likelihood.record_nodes`) looks nothing up: it spreads records
evenly over a jump, on purpose, since real terrain and real avalanches have no such gaps.

**Near some stops** (`near_stops`). At any place a block with less friction is faster, so F falls
with friction: runs go from a first guess to both sides until they are past the stops that are asked
for. What would be beyond is not run, but held at the last that was.
"""

from __future__ import annotations

from dataclasses import dataclass, field
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


def _frictions() -> Floats:
    even = np.arange(0.02, 1.6 + MU_STEP / 2, MU_STEP)
    below = np.geomspace(0.001, even[0], N_BELOW, endpoint=False)
    above = even[-1] + MU_STEP * np.cumsum(GROWTH ** np.arange(1, N_ABOVE + 1))
    return np.concatenate([below, even, above])


MU = _frictions()
"""Frictions at which runouts are tabulated, `[n_friction]`."""
EVEN = slice(N_BELOW, len(MU) - N_ABOVE)
"""Those with one spacing."""
JUMP_FACTOR = 5.0
"""A cell is a jump where the stop moves this many times as far as in the wider cell beside it."""


@dataclass(frozen=True, slots=True, eq=False)
class RunoutCurve:
    """F(μ) of one run, `[n_friction]`, or of several, `[n_rows, n_friction]`.

    `mu` `[n_friction]` are the frictions of the nodes, which rise. `x`, `y` are in m, `status` as
    in `physics.block`; where the block ran beyond the profile they are no stops.
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]
    mu: Floats = field(default_factory=lambda: MU)

    def __getitem__(self, rows: Any) -> RunoutCurve:
        """The curves of these rows, or the curve of one."""
        return RunoutCurve(self.x[rows], self.y[rows], self.status[rows], self.mu)

    @property
    def left(self) -> Bools:
        """Whether the block ran beyond the profile."""
        return np.asarray(self.status == LEFT_PROFILE)

    @property
    def broken(self) -> Bools:
        """Cells that are not straight (the rule above), `[…, n_friction - 1]`."""
        return broken_cells(self.x, self.status)

    def is_broken(self, cell: int) -> bool:
        """Whether one cell of one curve is `broken`, which the cells beside it decide."""
        first = max(cell - 1, 0)
        some = slice(first, cell + 3)
        return bool(broken_cells(self.x[some], self.status[some])[cell - first])

    @property
    def jumps(self) -> Bools:
        """Cells from one stop to the next over which F jumps, `[…, n_friction - 1]`."""
        stopped = self.status == STOPPED
        return np.asarray(self.broken & stopped[..., 1:] & stopped[..., :-1])

    def at(self, mu: Floats) -> tuple[Floats, Floats, NDArray[np.int8]]:
        """x, y and status at frictions `mu` `[(n_rows,) n]`; beyond the grid its end counts."""
        cell, share = located(steps_of(mu, self.mu), self.broken)
        x, y = between(self.x, cell, share), between(self.y, cell, share)
        return x, y, nearest(self.status, cell, share)

    def derivative(self) -> tuple[Floats, Floats]:
        """F'(μ) at the nodes: dx/dμ and dy/dμ (m), the mean of the straight cells beside each.

        nan where there is none: within jumps, where the block left, where it was held.
        """
        broken, width = self.broken, np.diff(self.mu)
        return _slope(self.x, broken, width), _slope(self.y, broken, width)


def tabulate(cells: Cells, starts: NDArray[np.int64], stride: int = 1) -> RunoutCurve:
    """F(μ) from each start node `[n_starts]`, at every `stride`-th friction of `MU`.

    Where the block ran beyond the profile, x and y are nan; where it was not released, the release.
    """
    stops = run(cells, starts, MU[::stride])
    return RunoutCurve(stops.x, stops.y, stops.status, MU[::stride])


def filled(coarse: RunoutCurve, stride: int) -> RunoutCurve:
    """The curves over `MU` from those over every `stride`-th friction of it: cubics between these.

    Straight beside a broken cell, in which the nearer end counts.
    """
    return RunoutCurve(*_filled(coarse.x, coarse.y, coarse.status, coarse.broken, stride))


@kernel
def _filled(x, y, status, broken, stride):  # type: ignore[no-untyped-def]
    n_rows, n = x.shape
    shape = n_rows, stride * (n - 1) + 1
    fine_x, fine_y, fine_status = np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.int8)
    for r in range(n_rows):
        for c in range(n):
            here = broken[r, max(c - 1, 0) : c + 2]
            smooth = 0 < c < n - 2 and not np.any(here)
            for k in range(stride if c < n - 1 else 1):
                share, i = k / stride, stride * c + k
                near = c + 1 if share >= 0.5 else c
                fine_x[r, i], fine_y[r, i], fine_status[r, i] = (
                    x[r, near],
                    y[r, near],
                    status[r, near],
                )
                if k > 0 and not broken[r, c]:
                    fine_x[r, i] = cubic_between(x[r], c, share, smooth)
                    fine_y[r, i] = cubic_between(y[r], c, share, smooth)
    return fine_x, fine_y, fine_status


@kernel(inner=True)
def cubic_between(values, c, share, smooth):  # type: ignore[no-untyped-def]
    """Value at this share of the way from node c to the next, within the range of both.

    By the cubic through the four nodes about them, straight where they are not `smooth`.
    """
    low, high = values[c], values[c + 1]
    straight = low + share * (high - low)
    if not smooth:
        return straight
    before = (values[c - 1] - 2.0 * low + high) * (2.0 - share)
    after = (low - 2.0 * high + values[c + 2]) * (1.0 + share)
    cubic = straight + share * (share - 1.0) * (before + after) / 6.0
    return min(max(cubic, min(low, high)), max(low, high))


def steps_of(mu: Floats, grid: Floats = MU) -> Floats:
    """Frictions `mu` in steps from the first node of `grid`; beyond the grid its end counts."""
    return np.asarray(np.interp(mu, grid, np.arange(len(grid))))


def broken_cells(x: Floats, status: NDArray[np.int8]) -> Bools:
    """Cells `[…, n_friction - 1]` that must not be interpolated (the rule above)."""
    moving = (status[..., 1:] == STOPPED) & (status[..., :-1] == STOPPED)
    gap = np.where(moving, np.abs(np.diff(np.where(np.isfinite(x), x, 0.0), axis=-1)), -1.0)
    none = np.full((*gap.shape[:-1], 1), -1.0)
    beside = np.maximum(
        np.concatenate([none, gap[..., :-1]], axis=-1),
        np.concatenate([gap[..., 1:], none], axis=-1),
    )
    jump = (beside >= 0.0) & (gap > JUMP_FACTOR * beside)
    return np.asarray(~moving | jump)


def located(steps: Floats, broken: Bools) -> tuple[NDArray[np.int64], Floats]:
    """Cell of each place `[…, n]` on the grid, and the share of its upper end: 0 or 1 if broken."""
    n_cells = broken.shape[-1]
    cell = np.minimum(steps.astype(np.int64), n_cells - 1)
    share = steps - cell
    flat = np.take_along_axis(broken, cell, axis=-1)
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
def inverse(values, broken, level):  # type: ignore[no-untyped-def]
    """Friction under which `values` `[n_friction]` over `MU` exceed a level.

    `values` fall, as stops do; they are inf where the profile was left. The friction is 0 where
    none exceeds the level, inf where all do, and the middle of a cell that is broken.
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
    if broken[n - 1] or not np.isfinite(part):
        part = 0.5
    return MU[n - 1] + part * (MU[n] - MU[n - 1])


def pieces(curve: RunoutCurve) -> tuple[Floats, NDArray[np.int8]]:
    """Curves in straight pieces of half a cell each, and their status, for `piece_at`.

    They are `[…, 2 n_friction, 4]`, `[…, 2 n_friction]`: in steps t of the grid, piece k holds for
    k - 1 ≤ 2t < k; the first and the last hold for everything below and above the grid, at the
    value of the end node. A row is (x at t = 0, dx/dt, y at t = 0, dy/dt). Left of profile is
    x = +inf, y = -inf.
    """
    flat, cell = ~curve.broken, np.arange(curve.status.shape[-1] - 1)
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


class FrictionGrid(NamedTuple):
    """Frictions `[n_friction]`, and those between `low` and `high`, which are even.

    The first of these has number `first`, and there are `per_step` of them to a unit of friction.
    """

    mu: Floats
    low: float
    high: float
    first: int
    per_step: float


def friction_grid(mu: Floats) -> FrictionGrid:
    """The grid with these frictions, its longest even stretch found."""
    width = np.diff(mu)
    edges = np.flatnonzero(~np.isclose(width[1:], width[:-1], rtol=1e-9)) + 1
    starts, ends = np.append(0, edges), np.append(edges, len(width))
    longest = int(np.argmax(ends - starts))
    first, last = int(starts[longest]), int(ends[longest])
    per_step = float((last - first) / (mu[last] - mu[first]))
    return FrictionGrid(
        np.ascontiguousarray(mu), float(mu[first]), float(mu[last]), first, per_step
    )


@kernel(forceinline=True)
def piece_at(rows, grid, mu):  # type: ignore[no-untyped-def]
    """Row of the piece that holds μ, and μ in steps of the grid."""
    if grid.low <= mu <= grid.high:
        t = grid.first + (mu - grid.low) * grid.per_step
    else:
        j = min(max(np.searchsorted(grid.mu, mu) - 1, 0), len(grid.mu) - 2)
        t = j + (mu - grid.mu[j]) / (grid.mu[j + 1] - grid.mu[j])
    return int(min(max(2.0 * t + 1.0, 0.0), len(rows) - 1.0)), t


def _slope(values: Floats, broken: Bools, width: Floats) -> Floats:
    """Mean slope of the straight cells beside each node, `[…, n_friction]`; nan where none is."""
    whole = (~broken).astype(float)
    # What a broken cell holds may be nan.
    step = np.diff(np.where(np.isfinite(values), values, 0.0), axis=-1)
    step = np.where(broken, 0.0, step / width)
    none = np.zeros((*step.shape[:-1], 1))

    def both(of_cells: Floats) -> Floats:
        return np.concatenate([none, of_cells], axis=-1) + np.concatenate([of_cells, none], axis=-1)

    count = both(whole)
    return np.where(count > 0.0, both(step) / np.maximum(count, 1.0), np.nan)


MARGIN, SLOW_MARGIN = 12, 3
"""Frictions beyond the stops asked for: what is a jump shows by the cells beside it, and the
screening reads speeds at every fourth friction. The second where resistance depends on speed, whose
frictions lie four times as far apart (`effects.site`)."""
WIDTH, SLOW_WIDTH = 32, 16
"""Frictions run at once; the second where resistance depends on speed, and each costs by itself."""


class NearStops(NamedTuple):
    """`curve` `[n_starts, n_friction]`, run from index `first` up to before `end` `[n_starts]`.

    Below and above these its end is repeated.
    """

    curve: RunoutCurve
    first: Ints
    end: Ints


def near_stops(cells: Cells, starts: NDArray[np.int64], mu: Floats, asked: Asked) -> NearStops:
    """F(μ) from each start node `[n_starts]` near what is asked, the same for every `middle`.

    `mu` `[n_friction]` rise.
    """
    width, margin = (SLOW_WIDTH, SLOW_MARGIN) if cells.speed_dependent else (WIDTH, MARGIN)
    stops, first, end = run_near(cells, starts, mu, asked, width, margin)
    return NearStops(RunoutCurve(stops.x, stops.y, stops.status, mu), first, end)
