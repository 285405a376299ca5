"""The closed-form step of several blocks through one cell (equation in `cells`)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.physics.cell_motion import at_speed
from avahazard.physics.cells import Cells
from avahazard.physics.constants import KERNEL

Floats = NDArray[np.float64]

LANES = 32
"""Frictions that go through a cell together: enough for the widest registers."""
CORRECTIONS = 3
GAUSS_LOW, GAUSS_HIGH = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)


@njit(**KERNEL, forceinline=True)
def step(
    cells: Cells, i: int, friction: Floats, w: Floats, row: int, row_new: int
) -> tuple[bool, bool]:
    """Fill `w[row_new]` `[LANES]`, u² at the end of cell i, from `w[row]` at its start.

    Returns whether any block may touch zero in the cell, and whether any may leave the ground.
    """
    g0, g1, g2, g3 = cells.growth[i, 0], cells.growth[i, 1], cells.growth[i, 2], cells.growth[i, 3]
    g4, g5, g6 = cells.growth[i, 4], cells.growth[i, 5], cells.growth[i, 6]
    d0, d1, d2, d3 = cells.drive[i, 0], cells.drive[i, 1], cells.drive[i, 2], cells.drive[i, 3]
    d4, d5, d6 = cells.drive[i, 4], cells.drive[i, 5], cells.drive[i, 6]
    factor, offset = cells.factor[i], cells.offset[i]
    dip, lift = cells.dip[i], cells.lift[i]
    can_lift = lift < np.inf
    low, high = False, False
    for j in range(LANES):
        m = friction[j] * factor + offset
        growth = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
        drive = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
        value = growth * w[row, j] + drive
        low |= value <= dip
        if can_lift:
            high |= (value > lift) | (w[row, j] > lift)
        w[row_new, j] = value
    return low, high


@njit(**KERNEL, forceinline=True)
def step_by_speed(
    cells: Cells, i: int, friction: Floats, w: Floats, row: int, row_new: int
) -> tuple[bool, bool]:
    """As `step`, for resistance that depends on speed: its mean over the w of the cell.

    The mean is taken at the two Gauss points between w at the start and at the end, which is
    predicted and then corrected once; √w near rest is met well enough by these.
    """
    growth, drive = cells.growth[i], cells.drive[i]
    dip, lift = cells.dip[i], cells.lift[i]
    low, high = False, False
    for j in range(LANES):
        w0 = w[row, j]
        first = second = w0
        value = w0
        for _ in range(CORRECTIONS):
            share = 0.5 * (
                at_speed(cells.speed_factor, first) + at_speed(cells.speed_factor, second)
            )
            m = friction[j] * share * cells.factor[i] + cells.offset[i]
            a, b = growth[6], drive[6]
            for k in range(5, -1, -1):
                a = a * m + growth[k]
                b = b * m + drive[k]
            push = at_speed(cells.speed_constant, first) + at_speed(cells.speed_constant, second)
            value = a * w0 + b - push * cells.length[i]
            rise = max(value, 0.0) - w0
            first, second = w0 + GAUSS_LOW * rise, w0 + GAUSS_HIGH * rise
        low |= value <= dip
        high |= (value > lift) | (w0 > lift)
        w[row_new, j] = value
    return low, high
