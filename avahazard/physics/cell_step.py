"""The closed-form step of several blocks through one cell (equation in `cells`)."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.cell_motion import between, table_place
from avahazard.physics.cells import Cells

BATCH_SIZE = 32
"""Frictions that go through a cell together: enough for the widest registers."""
LANES = 8
"""Blocks in one of these registers; a divisor of `BATCH_SIZE`."""
CORRECTIONS = 3
GAUSS_LOW, GAUSS_HIGH = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)


@kernel(forceinline=True)
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


@kernel(forceinline=True)
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
