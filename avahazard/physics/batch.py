"""Blocks with different frictions side by side, marched down the cells of a path together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.physics.cell_motion import end_accelerations, resisting
from avahazard.physics.cell_step import LANES, step, step_by_speed
from avahazard.physics.cells import Cells
from avahazard.physics.constants import GRAVITY, KERNEL
from avahazard.physics.contact import step_with_contact
from avahazard.physics.stop_place import first_zero, newton_zero

Floats = NDArray[np.float64]


class Lanes(NamedTuple):
    """State of `LANES` blocks; arrays `[LANES]`.

    `w` `[n_rows, LANES]` is u² at node k in row `k & rows`: with `rows` = 1 the last two nodes are
    kept, with -1 all. It is nan where a block rests: no comparison with nan is true, so blocks at
    rest need no mask. A block stops in cell `stop_cell` (-1: nowhere), at its fraction `stop_t`;
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
    lost_here: Floats
    held: Floats
    push: Floats
    rows: int


@njit(**KERNEL)
def new_lanes(n_rows: int, rows: int) -> Lanes:
    """Lanes with memory for the given rows of `Lanes.w`."""
    return Lanes(
        np.empty(LANES),
        np.empty((n_rows, LANES)),
        np.empty(LANES, dtype=np.int64),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        np.empty(LANES),
        rows,
    )


@njit(**KERNEL)
def release(cells: Cells, start: int, mu: Floats, first: int, lanes: Lanes) -> int:
    """Place blocks with frictions `mu[first:]` at the start node; the number that move off.

    A block moves off if the slope at the release exceeds what holds it.
    """
    row = start & lanes.rows
    lanes.w[row, :] = np.nan
    lanes.stop_cell[:] = -1
    lanes.lost_x[:] = np.nan
    for j in range(LANES):
        lanes.friction[j] = mu[min(first + j, len(mu) - 1)]
    if start == len(cells.length):
        return 0
    n_moving = 0
    slope = cells.slope[start]
    stretch = np.sqrt(1.0 + slope * slope)
    for j in range(min(LANES, len(mu) - first)):
        friction, constant = resisting(cells, start, lanes.friction[j], 0.0)
        if friction < slope - constant * stretch / GRAVITY:
            lanes.w[row, j] = 0.0
            n_moving += 1
    return n_moving


@njit(**KERNEL)
def march(cells: Cells, start: int, lanes: Lanes, n_moving: int) -> None:
    """Run the blocks from the start node until all rest or the path ends."""
    friction, w = lanes.friction, lanes.w
    for i in range(start, len(cells.length)):
        if n_moving == 0:
            break
        row, row_new = i & lanes.rows, (i + 1) & lanes.rows
        if cells.speed_dependent:
            low, high = step_by_speed(cells, i, friction, w, row, row_new, lanes.held, lanes.push)
        else:
            low, high = step(cells, i, friction, w, row, row_new)
        if high:
            held, push, lost = lanes.held, lanes.push, lanes.lost_here
            step_with_contact(cells, i, friction, w, row, row_new, held, push, lost)
            for j in range(LANES):
                if np.isnan(lanes.lost_x[j]):
                    lanes.lost_x[j] = lost[j]
        if low or high:
            n_moving -= stop_in_cell(cells, i, lanes)
    place_stops(cells, lanes)


@njit(**KERNEL, forceinline=True)
def stop_in_cell(cells: Cells, i: int, lanes: Lanes) -> int:
    """Stop the blocks whose w touches zero in cell i; their number."""
    row, row_new = i & lanes.rows, (i + 1) & lanes.rows
    h = cells.x[i + 1] - cells.x[i]
    dip = cells.dip[i]
    n = 0
    for j in range(LANES):
        if lanes.w[row_new, j] <= dip:
            w0, w1 = lanes.w[row, j], lanes.w[row_new, j]
            a0, a1 = end_accelerations(cells, i, lanes.friction[j], w0, w1)
            if w1 <= 0.0 or first_zero(w0, h * a0, w1, h * a1) >= 0.0:
                lanes.stop_cell[j] = i
                lanes.stop_w0[j], lanes.stop_d0[j] = w0, h * a0
                lanes.stop_w1[j], lanes.stop_d1[j] = w1, h * a1
                lanes.w[row_new, j] = np.nan
                n += 1
    return n


@njit(**KERNEL)
def place_stops(cells: Cells, lanes: Lanes) -> None:
    """Fill `Lanes.stop_t` of the blocks that stopped: in vectors where that converges."""
    w0, d0, w1, d1, t = lanes.stop_w0, lanes.stop_d0, lanes.stop_w1, lanes.stop_d1, lanes.stop_t
    for j in range(LANES):
        t[j] = newton_zero(w0[j], d0[j], w1[j], d1[j])
    for j in range(LANES):
        i = lanes.stop_cell[j]
        if i >= 0 and (np.isnan(t[j]) or cells.dip[i] > 0.0):
            t[j] = first_zero(w0[j], d0[j], w1[j], d1[j])
