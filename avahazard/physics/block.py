"""Runs of the block: several frictions side by side, marched down the cells of a path together.

Each step through a cell is in closed form (equation in `cells`). Where N = 0 the block follows the
path without friction, and the exact step is that of μ = 0. A cell turns so little that contact
changes in it at most once, at a fraction t. The block then ends where it would had contact not
changed, but for the friction that it meets less or more from there on.
With L = g + κw/cosθ of the motion as it began, which is N/cosθ on the ground,

    w₁ = w₁' ± 2μh ∫ L dt from t to 1,

h the length of the cell, + for a block that leaves the ground (L < 0) and - for one that lands; the
small factor `later` is what this difference itself grows by up to the end. L is a parabola but for
a known term of third order. As L = 0 at t, an error of t counts by its square.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import bare, kernel
from avahazard.physics.cell_motion import (
    between,
    elevation_in_cell,
    end_accelerations,
    first_zero,
    load,
    newton_zero,
    resisting,
    table_place,
)
from avahazard.physics.cells import GRAVITY, Cells

BATCH_SIZE = 32
"""Frictions that go through a cell together: enough for the widest registers."""
LANES = 8
"""Blocks in one of these registers; a divisor of `BATCH_SIZE`."""
CORRECTIONS = 3
GAUSS_LOW, GAUSS_HIGH = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)


@kernel(inner=True, forceinline=True)
def step(
    cells: Cells, i: int, friction: Floats, w: Floats, row: int, row_new: int
) -> tuple[bool, bool]:
    """Fill `w[row_new]` `[BATCH_SIZE]`, u² at the end of cell i, from `w[row]` at its start.

    Returns whether any block may touch zero in the cell, and whether any may leave the ground.
    """
    g0, g1, g2, g3 = cells.growth[i, 0], cells.growth[i, 1], cells.growth[i, 2], cells.growth[i, 3]
    g4, g5, g6 = cells.growth[i, 4], cells.growth[i, 5], cells.growth[i, 6]
    d0, d1, d2, d3 = cells.drive[i, 0], cells.drive[i, 1], cells.drive[i, 2], cells.drive[i, 3]
    d4, d5, d6 = cells.drive[i, 4], cells.drive[i, 5], cells.drive[i, 6]
    factor, offset = cells.factor[i], cells.offset[i]
    dip, lift = cells.dip[i], cells.lift[i]
    can_lift = lift < np.inf
    # Counted: a count stays in the registers of the comparison, an "or" over bits does not.
    low, high = 0, 0
    for j in range(BATCH_SIZE):
        m = friction[j] * factor + offset
        growth = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
        drive = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
        value = growth * w[row, j] + drive
        low += value <= dip
        if can_lift:
            high += (value > lift) | (w[row, j] > lift)
        w[row_new, j] = value
    return low > 0, high > 0


@kernel(inner=True, forceinline=True)
def step_by_speed(
    cells: Cells,
    i: int,
    friction: Floats,
    w: Floats,
    row: int,
    row_new: int,
    first: Floats,
    second: Floats,
    n_first: int,
) -> tuple[bool, bool]:
    """As `step`, for resistance that depends on speed: its mean over the w of the cell.

    The mean is taken at the two Gauss points between w at the start and at the end, which is
    predicted and then corrected; √w near rest is met well enough by these. Only the first `n_first`
    blocks still move. `first` and `second` `[BATCH_SIZE]` are working memory.
    """
    g0, g1, g2, g3 = cells.growth[i, 0], cells.growth[i, 1], cells.growth[i, 2], cells.growth[i, 3]
    g4, g5, g6 = cells.growth[i, 4], cells.growth[i, 5], cells.growth[i, 6]
    d0, d1, d2, d3 = cells.drive[i, 0], cells.drive[i, 1], cells.drive[i, 2], cells.drive[i, 3]
    d4, d5, d6 = cells.drive[i, 4], cells.drive[i, 5], cells.drive[i, 6]
    factor, offset, length = cells.factor[i], cells.offset[i], cells.length[i]
    dip, lift = cells.dip[i], cells.lift[i]
    factors, constants = cells.speed_factor, cells.speed_constant
    for j in range(n_first):
        first[j] = second[j] = w[row, j]
    # Each loop by itself goes through registers in vectors, but for those that look up.
    for _ in range(CORRECTIONS):
        for j in range(n_first):
            first[j] = table_place(factors, first[j])
            second[j] = table_place(factors, second[j])
        if cells.speed_resists:
            for j in range(n_first):
                share = 0.5 * (between(factors, first[j]) + between(factors, second[j]))
                push = between(constants, first[j]) + between(constants, second[j])
                first[j], second[j] = share, push
        else:
            for j in range(n_first):
                first[j] = 0.5 * (between(factors, first[j]) + between(factors, second[j]))
                second[j] = 0.0
        for j in range(n_first):
            w0, share, push = w[row, j], first[j], second[j]
            m = friction[j] * share * factor + offset
            growth = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
            drive = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
            value = growth * w0 + drive - push * length
            w[row_new, j] = value
            rise = max(value, 0.0) - w0
            first[j] = w0 + GAUSS_LOW * rise
            second[j] = w0 + GAUSS_HIGH * rise
    low, high = 0, 0
    for j in range(n_first):
        low += w[row_new, j] <= dip
        high += (w[row_new, j] > lift) | (w[row, j] > lift)
    w[row_new, n_first:] = np.nan
    return low > 0, high > 0


THIRD = 1.0 / 3.0


@kernel(inner=True, forceinline=True)
def step_with_contact(
    cells: Cells,
    i: int,
    mu: Floats,
    w: Floats,
    row: int,
    row_new: int,
    friction: Floats,
    push: Floats,
    lost_x: Floats,
) -> bool:
    """Step the batch that may lose contact in cell i; arrays `[BATCH_SIZE]`.

    `w[row_new]` holds the step on the ground and is overwritten where the block flies; `lost_x`
    receives the place where it lost contact, where it is nan so far. `friction` and `push` are
    working memory: resistance is taken at the mean w of the step on the ground. Returns whether any
    block may touch zero in the cell.
    """
    x, dip = cells.x[i], cells.dip[i]
    bend0, bend1 = cells.bend[i], cells.bend[i + 1]
    growth, drive = cells.growth[i, 0], cells.drive[i, 0]
    for j in range(BATCH_SIZE):
        friction[j] = mu[j] * cells.factor[i] + cells.offset[i]
        push[j] = 0.0
    if cells.speed_dependent:
        for j in range(BATCH_SIZE):
            w_mid = 0.5 * (w[row, j] + w[row_new, j])
            friction[j], constant = resisting(cells, i, mu[j], w_mid)
            push[j] = 2.0 * (constant - cells.constant[i]) * cells.length[i]
    low, changes = 0, 0
    for j in range(BATCH_SIZE):
        # No comparison with the nan of a block at rest is true.
        w0, w1 = w[row, j], w[row_new, j]
        w_free = growth * w0 + drive - push[j]
        flies = load(cells, bend0, w0) <= 0.0
        value = w_free if flies else w1
        load1 = load(cells, bend1, value)
        changes += (load1 > 0.0) if flies else (load1 <= 0.0)
        low += value <= dip
        w[row_new, j] = value
        lost_x[j] = x if flies & np.isnan(lost_x[j]) else lost_x[j]
    if changes > 0:
        return change_contact(cells, i, friction, w, row, row_new, lost_x)
    return low > 0


@kernel(inner=True)
def change_contact(
    cells: Cells, i: int, friction: Floats, w: Floats, row: int, row_new: int, lost_x: Floats
) -> bool:
    """Correct `w[row_new]`, the step as if contact did not change (module docstring).

    Returns whether any block may touch zero in the cell.
    """
    x, dip, h = cells.x[i], cells.dip[i], cells.x[i + 1] - cells.x[i]
    bend0, bend1 = cells.bend[i], cells.bend[i + 1]
    bend_m, bend_q = bend_inside(cells, i, 0.5), bend_inside(cells, i, 0.25)
    # A quarter of the factor of t (t - 1/2) (t - 1) in the bend.
    uneven = (bend_q - (0.375 * bend0 + 0.75 * bend_m - 0.125 * bend1)) * (16.0 / 3.0)
    fall = 0.25 * h * GRAVITY * (cells.slope[i] - cells.slope[i + 1])
    damping = cells.growth[i, 0] - 1.0
    turn1 = cells.curvature * h * bend1 * (2.0 / 3.0)
    turn0 = cells.curvature * h * (bend0 - bend1) / 6.0
    low = 0
    for j in range(BATCH_SIZE):
        w0, w1 = w[row, j], w[row_new, j]
        load0, load1 = load(cells, bend0, w0), load(cells, bend1, w1)
        lands = load0 <= 0.0
        sign = -1.0 if lands else 1.0
        # w in the middle of the cell, above the chord by `bow`.
        held = 0.0 if lands else friction[j]
        bow = fall - 0.25 * h * held * (load0 - load1) + 0.125 * damping * (w0 - w1)
        w_m = 0.5 * (w0 + w1) + bow
        load_m = load(cells, bend_m, w_m)
        # L = load0 + b t + c t², where it falls or rises through zero.
        b = 4.0 * load_m - 3.0 * load0 - load1
        c = 2.0 * (load0 + load1) - 4.0 * load_m
        root = np.sqrt(max(b * b - 4.0 * c * load0, 0.0))
        t = 2.0 * sign * load0 / (root - sign * b)
        t = t if t < 1.0 else 1.0
        left = 1.0 - t
        third_order = cells.curvature * ((bend1 - bend0) * bow - uneven * w_m)
        area = left * left * (c * left * THIRD - 0.5 * sign * root - third_order * t * t)
        turn = friction[j] * (turn1 + turn0 * left) if lands else 0.0
        later = 1.0 + left * (damping * THIRD + turn)
        value = w1 + 2.0 * sign * friction[j] * h * area * later
        changes = (load1 > 0.0) if lands else (load1 <= 0.0)
        w[row_new, j] = value if changes else w1
        low += w[row_new, j] <= dip
        lifts = changes & (not lands) & np.isnan(lost_x[j])
        lost_x[j] = x + h * t if lifts else lost_x[j]
    return low > 0


@kernel(inner=True, forceinline=True)
def bend_inside(cells: Cells, i: int, t: float) -> float:
    """dθ/dx at fraction t of cell i: d(tanθ)/dx cos²θ, tanθ the cubic through the cell's ends."""
    h = cells.x[i + 1] - cells.x[i]
    d0, d1 = h * cells.steepening[i], h * cells.steepening[i + 1]
    rise = cells.slope[i + 1] - cells.slope[i]
    c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
    slope = cells.slope[i] + t * (d0 + t * (c2 + t * c3))
    return (d0 + t * (2.0 * c2 + t * 3.0 * c3)) / (h * (1.0 + slope * slope))


class Batch(NamedTuple):
    """State of `BATCH_SIZE` blocks; arrays `[BATCH_SIZE]`.

    `w` `[n_rows, BATCH_SIZE]` is u² at node k in row `k & rows`: with `rows` = 1 the last two nodes
    are kept, with -1 all. It is nan where a block rests: no comparison with nan is true, so blocks
    at rest need no mask. A block stops in cell `stop_cell` (-1: nowhere), at its fraction `stop_t`;
    `stop_w0`, `stop_d0`, `stop_w1`, `stop_d1` are w and its derivative (per cell) at the ends of
    that cell. `lost_x` is where a block first lost contact with its bed, nan if it never did.
    """

    friction: Floats
    w: Floats
    stop_cell: NDArray[np.int64]
    stop_w0: Floats
    stop_d0: Floats
    stop_w1: Floats
    stop_d1: Floats
    stop_t: Floats
    lost_x: Floats
    held: Floats
    push: Floats
    rows: int


@kernel(inner=True)
def new_batch(n_rows: int, rows: int) -> Batch:
    """Batch with memory for the given rows of `Batch.w`."""
    friction, w = np.empty(BATCH_SIZE), np.empty((n_rows, BATCH_SIZE))
    stop_cell, stop = np.empty(BATCH_SIZE, dtype=np.int64), np.empty((5, BATCH_SIZE))
    lost_x, held, push = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE), np.empty(BATCH_SIZE)
    of_stop = stop[0], stop[1], stop[2], stop[3], stop[4]
    return Batch(friction, w, stop_cell, *of_stop, lost_x, held, push, rows)


@kernel
def release(cells: Cells, start: int, mu: Floats, batch: Batch) -> int:
    """Place blocks with the first of `mu` at the start node; the number that move off."""
    cells, mu, batch = bare(cells), bare(mu), bare(batch)
    row = start & batch.rows
    batch.w[row, :] = np.nan
    batch.stop_cell[:] = -1
    batch.lost_x[:] = np.nan
    for j in range(BATCH_SIZE):
        batch.friction[j] = mu[min(j, len(mu) - 1)]
    if start == len(cells.length):
        return 0
    n_moving = 0
    slope = cells.slope[start]
    stretch = np.sqrt(1.0 + slope * slope)
    for j in range(min(BATCH_SIZE, len(mu))):
        friction, constant = resisting(cells, start, batch.friction[j], 0.0)
        if friction < slope - constant * stretch / GRAVITY:
            batch.w[row, j] = 0.0
            n_moving += 1
    return n_moving


@kernel
def march(cells: Cells, start: int, batch: Batch, n_moving: int) -> None:
    """Run the blocks from the start node until all rest or the path ends."""
    cells, batch = bare(cells), bare(batch)
    friction, w = batch.friction, batch.w
    n_first = first_of_batch(w, start & batch.rows)
    for i in range(start, len(cells.length)):
        if n_moving == 0:
            break
        row, row_new = i & batch.rows, (i + 1) & batch.rows
        if cells.speed_dependent:
            held, push = batch.held, batch.push
            low, high = step_by_speed(cells, i, friction, w, row, row_new, held, push, n_first)
        else:
            low, high = step(cells, i, friction, w, row, row_new)
        if high:
            held, push, lost_x = batch.held, batch.push, batch.lost_x
            low = step_with_contact(cells, i, friction, w, row, row_new, held, push, lost_x)
        if low:
            n_stopped = stop_in_cell(cells, i, batch)
            n_moving -= n_stopped
            if n_stopped and cells.speed_dependent:
                n_first = first_of_batch(w, row_new)
    place_stops(cells, batch)


@kernel(inner=True, forceinline=True)
def first_of_batch(w: Floats, row: int) -> int:
    """How many blocks, from the first on, hold all that still move: a multiple of `LANES`."""
    n = 0
    for j in range(BATCH_SIZE):
        if not np.isnan(w[row, j]):
            n = j + 1
    return (n + LANES - 1) // LANES * LANES


@kernel(inner=True, forceinline=True)
def stop_in_cell(cells: Cells, i: int, batch: Batch) -> int:
    """Stop the blocks whose w touches zero in cell i; their number."""
    row, row_new = i & batch.rows, (i + 1) & batch.rows
    h = cells.x[i + 1] - cells.x[i]
    dip = cells.dip[i]
    n = 0
    for j in range(BATCH_SIZE):
        if batch.w[row_new, j] <= dip:
            w0, w1 = batch.w[row, j], batch.w[row_new, j]
            a0, a1 = end_accelerations(cells, i, batch.friction[j], w0, w1)
            if w1 <= 0.0 or first_zero(w0, h * a0, w1, h * a1) >= 0.0:
                batch.stop_cell[j] = i
                batch.stop_w0[j], batch.stop_d0[j] = w0, h * a0
                batch.stop_w1[j], batch.stop_d1[j] = w1, h * a1
                batch.w[row_new, j] = np.nan
                n += 1
    return n


@kernel(inner=True)
def place_stops(cells: Cells, batch: Batch) -> None:
    """Fill `Batch.stop_t` of the blocks that stopped: in vectors where that converges."""
    w0, d0, w1, d1, t = batch.stop_w0, batch.stop_d0, batch.stop_w1, batch.stop_d1, batch.stop_t
    for j in range(BATCH_SIZE):
        t[j] = newton_zero(w0[j], d0[j], w1[j], d1[j])
    for j in range(BATCH_SIZE):
        i = batch.stop_cell[j]
        if i >= 0 and (np.isnan(t[j]) or cells.dip[i] > 0.0):
            t[j] = first_zero(w0[j], d0[j], w1[j], d1[j])


STOPPED, LEFT_PROFILE, NOT_RELEASED = 0, 1, 2
STATUS_NAMES = ("stopped", "left_profile", "not_released")


class Stops(NamedTuple):
    """Ends of runs, each array `[n_starts, n_friction]`.

    `x`, `y` (m) are nan where the block ran beyond the profile and the release where it was not
    released; `status` is one of STOPPED, LEFT_PROFILE, NOT_RELEASED; `lift_off_x` is where the
    block first lost contact with its bed, nan where it never did.
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]
    lift_off_x: Floats


class Asked(NamedTuple):
    """Stops asked for from each start, `[n_starts]`.

    Those between the places `low` and `high` (m); where `high` is inf all beyond the profile
    is asked for as well. Runs begin about the friction with index `middle`.
    """

    low: Floats
    high: Floats
    middle: NDArray[np.int64]


def every_stop(n_starts: int) -> Asked:
    """All stops are asked for."""
    low, high = np.full(n_starts, -np.inf), np.full(n_starts, np.inf)
    return Asked(low, high, np.zeros(n_starts, np.int64))


def run(cells: Cells, starts: NDArray[np.int64], mu: Floats) -> Stops:
    """Run the block from each start node with each friction.

    `starts` `[n_starts]` are node indices, `mu` `[n_friction]` Coulomb frictions (any order;
    neighbours that are close run fastest).
    """
    every = every_stop(len(starts))
    *stops, _, _ = run_near(cells, starts, np.ascontiguousarray(mu), *every, BATCH_SIZE, 0)
    return Stops(*stops)


@kernel
def run_near(cells, starts, mu, low, high, middle, width, margin):  # type: ignore[no-untyped-def]
    """Run the block with the rising frictions `mu` that stop it where it is `Asked` for.

    And with `margin` more on either side, `width` at once (a batch at most). Returns the fields of
    `Stops`, and from each start the first friction that was run and the one before which that ends,
    `[n_starts]` each; below and above these the end of what was run is repeated.
    """
    cells, mu = bare(cells), bare(mu)
    n_starts, n = len(starts), len(mu)
    shape = n_starts, n
    x, y, lift_off_x = np.empty(shape), np.empty(shape), np.empty(shape)
    status = np.empty(shape, dtype=np.int8)
    firsts, ends = np.empty(n_starts, dtype=np.int64), np.empty(n_starts, dtype=np.int64)
    batch = new_batch(2, 1)
    for s in range(n_starts):
        stops = x[s], y[s], status[s], lift_off_x[s]
        # At the first guess, then on to either side.
        first = end = max(0, min(middle[s] - width // 2, n - width))
        while end == first or (end < n and not x[s, end - 1 - margin] < low[s]):
            begin, end = end, min(n, end + width)
            _fill_stops(cells, starts[s], mu, begin, end, batch, stops)
        while first > 0 and not _beyond(x[s], status[s], first + margin, high[s]):
            stop, first = first, max(0, first - width)
            _fill_stops(cells, starts[s], mu, first, stop, batch, stops)
        # As if no more had been run than is needed, wherever it began.
        above, below = first, end - 1
        while above + 1 < end and _beyond(x[s], status[s], above + 1, high[s]):
            above += 1
        while below - 1 >= first and x[s, below - 1] < low[s]:
            below -= 1
        first, end = max(above - margin, first), min(below + 1 + margin, end)
        firsts[s], ends[s] = first, end
        x[s, :first], y[s, :first], status[s, :first] = x[s, first], y[s, first], status[s, first]
        x[s, end:], y[s, end:] = x[s, end - 1], y[s, end - 1]
        status[s, end:] = status[s, end - 1]
    return x, y, status, lift_off_x, firsts, ends


@kernel(inner=True)
def _beyond(x, status, j, high):  # type: ignore[no-untyped-def]
    """Whether friction j brings the block past all that is asked for."""
    return np.isfinite(high) if status[j] == LEFT_PROFILE else x[j] > high


@kernel
def _fill_stops(cells, start, mu, begin, end, batch, stops):  # type: ignore[no-untyped-def]
    """Fill in the `Stops` of a start for the frictions from `begin` to `end`, one batch at most."""
    cells, mu, batch, stops = bare(cells), bare(mu), bare(batch), bare(stops)
    x, y, status, lift_off_x = stops
    n_moving = release(cells, start, mu[begin:end], batch)
    for j in range(begin, end):
        moves = not np.isnan(batch.w[start & 1, j - begin])
        x[j], y[j] = np.nan, np.nan
        status[j] = LEFT_PROFILE if moves else NOT_RELEASED
        if not moves:
            x[j], y[j] = cells.x[start], cells.y[start]
    march(cells, start, batch, n_moving)
    for j in range(begin, end):
        lift_off_x[j] = batch.lost_x[j - begin]
        i = batch.stop_cell[j - begin]
        if i >= 0:
            t = batch.stop_t[j - begin]
            status[j] = STOPPED
            x[j] = cells.x[i] + t * (cells.x[i + 1] - cells.x[i])
            y[j] = elevation_in_cell(cells, i, t)
