"""The closed-form step of several blocks through one cell (equation in `cells`).

Where N = 0 the block follows the path without friction, and the exact step is that of μ = 0. A cell
turns so little that contact changes in it at most once, at a fraction t. The block then ends where
it would had contact not changed, but for the friction that it meets less or more from there on.
With L = g + κw/cosθ of the motion as it began, which is N/cosθ on the ground,

    w₁ = w₁' ± 2μh ∫ L dt from t to 1,

h the length of the cell, + for a block that leaves the ground (L < 0) and - for one that lands; the
small factor `later` is what this difference itself grows by up to the end. L is a parabola but for
a known term of third order. As L = 0 at t, an error of t counts by its square.
"""

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.cell_motion import between, load, resisting, table_place
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
