"""The equation of motion inside one cell, and where in it a block stops.

w = u² in m²/s², x in m. All functions work on one block; the kernels inline them over several.
"""

import numpy as np

from avahazard.kernels import kernel
from avahazard.physics.cells import GRAVITY, SPEED_STEP, Cells


@kernel(inner=True, forceinline=True)
def at_speed(table: np.ndarray, w: float) -> float:
    """Value of a table over speed (`cells.SPEEDS`) at speed √w, linear in between."""
    return between(table, table_place(table, w))


@kernel(inner=True, forceinline=True)
def table_place(table: np.ndarray, w: float) -> float:
    """Place of speed √w in a table over speed, in steps of it; its end for what is beyond."""
    place = np.sqrt(max(w, 0.0)) * (1.0 / SPEED_STEP)
    last = len(table) - 1.0
    return place if place < last else last  # also for the nan of a block at rest


@kernel(inner=True, forceinline=True)
def between(table: np.ndarray, place: float) -> float:
    """Value of a table at a place, linear in between."""
    j = np.uint32(min(int(place), len(table) - 2))
    return table[j] + (place - j) * (table[j + np.uint32(1)] - table[j])


@kernel(inner=True, forceinline=True)
def resisting(cells: Cells, i: int, mu: float, w: float) -> tuple[float, float]:
    """Friction and constant resistance (m/s²) in cell i of a block of friction `mu` and u² = w."""
    constant = cells.constant[i]
    if cells.speed_dependent:
        mu *= at_speed(cells.speed_factor, w)
        constant += at_speed(cells.speed_constant, w)
    return mu * cells.factor[i] + cells.offset[i], constant


@kernel(inner=True, forceinline=True)
def load(cells: Cells, bend: float, w: float) -> float:
    """N/cosθ if held to the ground, N = g cosθ + κw and κ = -bend cosθ; below zero it flies."""
    return GRAVITY - cells.curvature * bend * w


@kernel(inner=True, forceinline=True)
def node_acceleration(cells: Cells, i: int, node: int, mu: float, w: float) -> float:
    """dw/dx at a node, an end of cell i, on the ground or off it: equation 2.3 with effects."""
    slope = cells.slope[node]
    stretch = np.sqrt(1.0 + slope * slope)
    loaded = max(load(cells, cells.bend[node], w), 0.0)
    friction, constant = resisting(cells, i, mu, w)
    resisted = (constant + cells.drag[i] * w) * stretch
    return 2.0 * (GRAVITY * slope - friction * loaded - resisted)


@kernel(inner=True, forceinline=True)
def end_accelerations(cells: Cells, i: int, mu: float, w0: float, w1: float) -> tuple[float, float]:
    """dw/dx at the start and the end of cell i."""
    return node_acceleration(cells, i, i, mu, w0), node_acceleration(cells, i, i + 1, mu, w1)


@kernel(inner=True, forceinline=True)
def hermite(t: float, v0: float, d0: float, v1: float, d1: float) -> float:
    """Cubic through v0, v1 with derivatives d0, d1 (per unit of t)."""
    c2 = 3.0 * (v1 - v0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (v1 - v0)
    return v0 + t * (d0 + t * (c2 + t * c3))


@kernel(inner=True, forceinline=True)
def elevation_in_cell(cells: Cells, i: int, t: float) -> float:
    """Elevation of the path at fraction t of cell i."""
    h = cells.x[i + 1] - cells.x[i]
    return hermite(t, cells.y[i], -h * cells.slope[i], cells.y[i + 1], -h * cells.slope[i + 1])


@kernel(inner=True, forceinline=True)
def newton_zero(w0: float, d0: float, w1: float, d1: float) -> float:
    """Zero of the cubic with these end values and slopes that falls from w0 > 0 to w1 ≤ 0.

    Four steps of Newton's method from the chord, without a branch; nan where they have not
    converged.
    """
    c2 = 3.0 * (w1 - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w1 - w0)
    t = w0 / (w0 - w1)
    step = 1.0
    for _ in range(4):
        value = w0 + t * (d0 + t * (c2 + t * c3))
        step = value / (d0 + t * (2.0 * c2 + t * 3.0 * c3))
        t -= step
    return t if (w0 > 0.0) & (abs(step) < 1e-7) & (t >= 0.0) & (t <= 1.0) else np.nan


@kernel
def first_zero(w0: float, d0: float, w1: float, d1: float) -> float:
    """First t in (0, 1] where the cubic with these end values and slopes is ≤ 0; -1 if none."""
    c2 = 3.0 * (w1 - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w1 - w0)
    low, high = 0.0, -1.0
    # The minimum between, where the derivative d0 + 2 c2 t + 3 c3 t² rises through zero.
    discriminant = c2 * c2 - 3.0 * c3 * d0
    if discriminant > 0.0:
        root = np.sqrt(discriminant)
        # The stable form of (-c2 + root) / (3 c3), the root where the derivative rises.
        bottom = -d0 / (c2 + root) if c2 > 0.0 else (root - c2) / (3.0 * c3)
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
        t_new = t - value / slope
        if not low <= t_new <= high:
            t_new = 0.5 * (low + high)
        if abs(t_new - t) < 1e-10:
            return t_new
        t = t_new
    return t
