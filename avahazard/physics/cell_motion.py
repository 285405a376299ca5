"""Motion inside one cell, where the closed form of its step is not enough.

These small kernels find the stop within a cell, follow the block through a loss of contact, and
tell its speed between the nodes. w = u² in m²/s², x in m; all work on one block in one cell.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from avahazard.physics.cells import Cells
from avahazard.physics.constants import GRAVITY, KEEPS_NAN
from avahazard.physics.resistance import SPEED_STEP

FLIGHT_STEP_M = 4.0
"""Step of the integration where contact may be lost."""


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def at_speed(table: np.ndarray, w: float) -> float:
    """Value of a table over speed (`resistance.SPEEDS`) at speed √w, linear in between."""
    place = np.sqrt(max(w, 0.0)) / SPEED_STEP
    last = len(table) - 1
    if place >= last:
        return table[last]
    j = int(place)
    return table[j] + (place - j) * (table[j + 1] - table[j])


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def cell_friction(cells: Cells, i: int, mu: float, w: float) -> float:
    """Friction in cell i of a block with friction `mu` and squared speed w."""
    friction = mu * cells.factor[i]
    if cells.speed_dependent:
        friction *= at_speed(cells.speed_factor, w)
    return friction + cells.offset[i]


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def acceleration(
    cells: Cells, i: int, mu: float, w: float, slope: float, bend: float, grounded: bool
) -> float:
    """dw/dx in cell i (equation 2.3 with w = u² and effects), `bend` = dθ/dx.

    `load` is N/cosθ with N = g cosθ + κw, κ = -bend cosθ, or nothing off the ground.
    """
    stretch = np.sqrt(1.0 + slope * slope)
    load = GRAVITY - cells.curvature * bend * w if grounded else 0.0
    constant = cells.constant[i]
    if cells.speed_dependent:
        constant += at_speed(cells.speed_constant, w)
    resisting = cell_friction(cells, i, mu, w) * load + (constant + cells.drag[i] * w) * stretch
    return 2.0 * (GRAVITY * slope - resisting)


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def end_accelerations(cells: Cells, i: int, mu: float, w0: float, w1: float) -> tuple[float, float]:
    """dw/dx at the start and the end of cell i."""
    slope0, slope1 = cells.slope[i], cells.slope[i + 1]
    bend0 = cells.steepening[i] / (1.0 + slope0 * slope0)
    bend1 = cells.steepening[i + 1] / (1.0 + slope1 * slope1)
    return (
        acceleration(cells, i, mu, w0, slope0, bend0, True),
        acceleration(cells, i, mu, w1, slope1, bend1, True),
    )


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def first_zero(w0: float, d0: float, w1: float, d1: float) -> float:
    """First t in (0, 1] where the cubic with these end values and slopes is ≤ 0; -1 if none.

    A zero at t = 0 itself (the release) is not counted.
    """
    c2 = 3.0 * (w1 - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w1 - w0)
    low, high = 0.0, -1.0
    # The minimum between, where the derivative d0 + 2 c2 t + 3 c3 t² rises through zero.
    discriminant = c2 * c2 - 3.0 * c3 * d0
    if discriminant > 0.0:
        root = np.sqrt(discriminant)
        # The stable form of (-c2 + root) / (3 c3), the root where the derivative rises.
        if c2 > 0.0:
            bottom = -d0 / (c2 + root)
        elif c3 != 0.0:
            bottom = (root - c2) / (3.0 * c3)
        else:
            bottom = -1.0
        if 0.0 < bottom < 1.0 and w0 + bottom * (d0 + bottom * (c2 + bottom * c3)) <= 0.0:
            high = bottom
    if high < 0.0:
        if w1 > 0.0:
            return -1.0
        high = 1.0
    if w0 <= 0.0:
        low = 1e-9
    # The chord to the end is a good first guess where w falls through zero.
    t = w0 / (w0 - w1) if w0 > 0.0 and w1 < 0.0 and high == 1.0 else 0.5 * (low + high)
    for _ in range(60):
        value = w0 + t * (d0 + t * (c2 + t * c3))
        if value > 0.0:
            low = t
        else:
            high = t
        slope = d0 + t * (2.0 * c2 + 3.0 * t * c3)
        step = value / slope if slope != 0.0 else 2.0
        t_new = t - step
        if not low <= t_new <= high:
            t_new = 0.5 * (low + high)
        if abs(t_new - t) < 1e-10:
            return t_new
        t = t_new
    return t


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def hermite(t: float, v0: float, d0: float, v1: float, d1: float) -> float:
    """Cubic through v0, v1 with derivatives d0, d1 (per unit of t)."""
    return v0 + t * (d0 + t * (3.0 * (v1 - v0) - 2.0 * d0 - d1 + t * (d0 + d1 - 2.0 * (v1 - v0))))


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def elevation_in_cell(cells: Cells, i: int, t: float) -> float:
    """Elevation of the path at fraction t of cell i."""
    h = cells.x[i + 1] - cells.x[i]
    return hermite(t, cells.y[i], -h * cells.slope[i], cells.y[i + 1], -h * cells.slope[i + 1])


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def slope_in_cell(cells: Cells, i: int, t: float) -> tuple[float, float]:
    """tanθ and dθ/dx at fraction t of cell i, the slope cubic between its ends."""
    h = cells.x[i + 1] - cells.x[i]
    v0, d0 = cells.slope[i], h * cells.steepening[i]
    v1, d1 = cells.slope[i + 1], h * cells.steepening[i + 1]
    c2 = 3.0 * (v1 - v0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (v1 - v0)
    slope = v0 + t * (d0 + t * (c2 + t * c3))
    return slope, (d0 + t * (2.0 * c2 + 3.0 * t * c3)) / (h * (1.0 + slope * slope))


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def fly(cells: Cells, i: int, mu: float, w: float) -> tuple[float, float, float]:
    """Follow the block through cell i where it may be on the ground or off it.

    Returns w at the end, the fraction of the cell where it stopped (-1 if it did not), and the
    fraction where it first lost the ground (-1 if it did not). While N = 0 the block follows
    the path without friction, which over a whole cell is its step at μ = 0. Else classical
    Runge-Kutta steps of order 4, cut where contact changes: there N has a kink.
    """
    free = cells.growth[i, 0] * w + cells.drive[i, 0]
    if min(w, free) > cells.free_above[i] and not cells.speed_dependent:
        return free, -1.0, 0.0
    n = int(np.ceil((cells.x[i + 1] - cells.x[i]) / FLIGHT_STEP_M))
    dt = 1.0 / n
    lost = -1.0
    surplus = load_surplus(cells, i, 0.0, w)
    for k in range(n):
        t, step = k * dt, dt
        # At most two changes of contact are followed within one step.
        for _ in range(3):
            if surplus < 0.0 and lost < 0.0:
                lost = t
            w_new = flight_step(cells, i, mu, t, step, w, surplus > 0.0)
            surplus_new = load_surplus(cells, i, t + step, w_new)
            if (surplus > 0.0) == (surplus_new > 0.0) or w_new <= 0.0:
                break
            # Step to where the load changes sign, then go on in the other state.
            part = step * surplus / (surplus - surplus_new)
            w_part = flight_step(cells, i, mu, t, part, w, surplus > 0.0)
            at_part = load_surplus(cells, i, t + part, w_part)
            if (surplus > 0.0) == (at_part > 0.0):
                part += (step - part) * at_part / (at_part - surplus_new)
            else:
                part *= surplus / (surplus - at_part)
            w = flight_step(cells, i, mu, t, part, w, surplus > 0.0)
            surplus = surplus_new
            t, step = t + part, step - part
        if w_new <= 0.0:
            return 0.0, t + step * w / (w - w_new), lost
        w, surplus = w_new, surplus_new
    return w, -1.0, lost


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def load_surplus(cells: Cells, i: int, t: float, w: float) -> float:
    """g + κw/cosθ at fraction t of cell i: below zero the block is off the ground."""
    return GRAVITY - cells.curvature * slope_in_cell(cells, i, t)[1] * w


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def flight_step(
    cells: Cells, i: int, mu: float, t: float, dt: float, w: float, grounded: bool
) -> float:
    """One Runge-Kutta step of w over the fraction dt of cell i, on the ground or off it."""
    h = dt * (cells.x[i + 1] - cells.x[i])
    slope, bend = slope_in_cell(cells, i, t)
    k1 = h * acceleration(cells, i, mu, w, slope, bend, grounded)
    slope, bend = slope_in_cell(cells, i, t + 0.5 * dt)
    k2 = h * acceleration(cells, i, mu, w + 0.5 * k1, slope, bend, grounded)
    k3 = h * acceleration(cells, i, mu, w + 0.5 * k2, slope, bend, grounded)
    slope, bend = slope_in_cell(cells, i, t + dt)
    k4 = h * acceleration(cells, i, mu, w + k3, slope, bend, grounded)
    return w + (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
