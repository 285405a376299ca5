"""Cells in which blocks may leave the ground or come back to it.

Where N = 0 the block follows the path without friction, and the exact step of a cell (`cells`) is
that of μ = 0. A cell turns so little that contact changes in it at most once, at a fraction t. The
block then ends where it would had contact not changed, but for the friction that it meets less or
more from there on. With L = g + κw/cosθ of the motion as it began, which is N/cosθ on the ground,

    w₁ = w₁' ± 2μh ∫ L dt from t to 1,

h the length of the cell, + for a block that leaves the ground (L < 0) and - for one that lands; the
small factor `later` is what this difference itself grows by up to the end. L is a parabola but for
a known term of third order. As L = 0 at t, an error of t counts by its square.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.cell_motion import load, resisting
from avahazard.physics.cell_step import BATCH_SIZE
from avahazard.physics.cells import Cells
from avahazard.physics.constants import GRAVITY

THIRD = 1.0 / 3.0


@kernel(forceinline=True)
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
