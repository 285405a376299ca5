"""Cells in which blocks may leave the ground or come back to it.

Where N = 0 the block follows the path without friction. N has a kink there, so a cell is cut where
contact changes: up to that place the block moves as it began, then by the equation of motion.
A cell turns so little that one Runge-Kutta step of order 4 serves for the rest of it, and that
contact changes at most once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.cell_motion import acceleration, load, resisting
from avahazard.physics.cells import Cells


class Shape(NamedTuple):
    """A cell of length `h` m; t is the fraction of it.

    tanθ is the cubic with coefficients s, 1/cosθ the parabola r, cos²θ/h the parabola q.
    """

    h: float
    s0: float
    s1: float
    s2: float
    s3: float
    r0: float
    r1: float
    r2: float
    q0: float
    q1: float
    q2: float


@kernel
def step_with_contact(
    cells: Cells,
    i: int,
    mu: Floats,
    w: Floats,
    row: int,
    row_new: int,
    friction: Floats,
    constant: Floats,
    lost_x: Floats,
) -> None:
    """Step the batch that may lose contact in cell i; arrays `[batch_size]`.

    `w[row_new]` holds the step on the ground and is overwritten where the block flies; `lost_x`
    receives the place where it lost contact, nan where it did not. `friction` and `constant` are
    working memory: resistance is taken at the mean w of the step on the ground.
    """
    shape = cell_shape(cells, i)
    x, lift = cells.x[i], cells.lift[i]
    for j in range(len(mu)):
        w_mid = 0.5 * (w[row, j] + w[row_new, j])
        friction[j], constant[j] = resisting(cells, i, mu[j], w_mid)
    for j in range(len(mu)):
        w0, w1 = w[row, j], w[row_new, j]
        w_end, t = fly(cells, i, shape, friction[j], constant[j], w0, w1)
        concerned = (w0 > lift) | (w1 > lift)
        w[row_new, j] = w_end if concerned else w1
        lost_x[j] = x + t * shape.h if concerned else np.nan


@kernel(inner=True, forceinline=True)
def fly(
    cells: Cells,
    i: int,
    shape: Shape,
    friction: float,
    constant: float,
    w0: float,
    w_ground: float,
) -> tuple[float, float]:
    """w at the end of the cell, and the fraction of it where the block was first off the ground."""
    load0 = load(cells, bend_at(shape, 0.0), w0)
    grounded = load0 > 0.0
    # As if contact did not change: a whole step on the ground or off it.
    w_free = runge_kutta(cells, i, shape, 0.0, constant, w0, 0.0)
    w_same = w_ground if grounded else w_free
    held = friction if grounded else 0.0
    load1 = load(cells, bend_at(shape, 1.0), w_same)
    changes = grounded != (load1 > 0.0)
    d0 = shape.h * rate_at(cells, i, shape, held, constant, w0, 0.0, load0)
    d1 = shape.h * rate_at(cells, i, shape, held, constant, w_same, 1.0, load1)
    c2 = 3.0 * (w_same - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w_same - w0)
    # The place where N = 0, by Newton's method from the chord.
    t = load0 / (load0 - load1) if changes else 1.0
    for _ in range(2):
        w = w0 + t * (d0 + t * (c2 + t * c3))
        bend = bend_at(shape, t)
        rate = bend_rate_at(shape, t) * w + bend * (d0 + t * (2.0 * c2 + t * 3.0 * c3))
        t_new = t + load(cells, bend, w) / (cells.curvature * rate)
        t = min(max(t_new, 0.0), 1.0) if changes else t
    w = w0 + t * (d0 + t * (c2 + t * c3))
    w_changed = runge_kutta(cells, i, shape, friction, constant, w, t)
    off_at = (t if changes else np.nan) if grounded else 0.0
    return (w_changed if changes else w_same), off_at


@kernel(inner=True, forceinline=True)
def runge_kutta(
    cells: Cells, i: int, shape: Shape, friction: float, constant: float, w: float, t: float
) -> float:
    """w at the end of the cell from w at fraction t of it, on the ground or off it."""
    h = (1.0 - t) * shape.h
    middle = 0.5 * (1.0 + t)
    bend0, bend_m, bend1 = bend_at(shape, t), bend_at(shape, middle), bend_at(shape, 1.0)
    loaded = max(load(cells, bend0, w), 0.0)
    k1 = h * rate_at(cells, i, shape, friction, constant, w, t, loaded)
    v = w + 0.5 * k1
    loaded = max(load(cells, bend_m, v), 0.0)
    k2 = h * rate_at(cells, i, shape, friction, constant, v, middle, loaded)
    v = w + 0.5 * k2
    loaded = max(load(cells, bend_m, v), 0.0)
    k3 = h * rate_at(cells, i, shape, friction, constant, v, middle, loaded)
    v = w + k3
    loaded = max(load(cells, bend1, v), 0.0)
    k4 = h * rate_at(cells, i, shape, friction, constant, v, 1.0, loaded)
    return w + (k1 + 2.0 * (k2 + k3) + k4) / 6.0


@kernel(inner=True, forceinline=True)
def rate_at(
    cells: Cells,
    i: int,
    shape: Shape,
    friction: float,
    constant: float,
    w: float,
    t: float,
    loaded: float,
) -> float:
    """dw/dx at fraction t of the cell under the load `loaded`."""
    slope, stretch = slope_at(shape, t), stretch_at(shape, t)
    return acceleration(slope, stretch, loaded, friction, constant, cells.drag[i] * w)


@kernel(inner=True, forceinline=True)
def cell_shape(cells: Cells, i: int) -> Shape:
    """The shape of cell i from slope and bend at its ends."""
    h = cells.x[i + 1] - cells.x[i]
    s0, rise = cells.slope[i], cells.slope[i + 1] - cells.slope[i]
    s1 = h * cells.steepening[i]
    s2 = 3.0 * rise - 2.0 * s1 - h * cells.steepening[i + 1]
    s3 = rise - s1 - s2
    middle = s0 + 0.5 * (s1 + 0.5 * (s2 + 0.5 * s3))
    a, b, c = 1.0 + s0 * s0, 1.0 + middle * middle, 1.0 + cells.slope[i + 1] ** 2
    r0, r1, r2 = parabola(np.sqrt(a), np.sqrt(b), np.sqrt(c))
    q0, q1, q2 = parabola(1.0 / (h * a), 1.0 / (h * b), 1.0 / (h * c))
    return Shape(h, s0, s1, s2, s3, r0, r1, r2, q0, q1, q2)


@kernel(forceinline=True)
def parabola(start: float, middle: float, end: float) -> tuple[float, float, float]:
    """Coefficients of the parabola with these values at t = 0, 1/2, 1."""
    linear = 4.0 * middle - 3.0 * start - end
    return start, linear, end - start - linear


@kernel(inner=True, forceinline=True)
def slope_at(shape: Shape, t: float) -> float:
    """tanθ at fraction t of the cell."""
    return shape.s0 + t * (shape.s1 + t * (shape.s2 + t * shape.s3))


@kernel(inner=True, forceinline=True)
def bend_at(shape: Shape, t: float) -> float:
    """dθ/dx at fraction t of the cell: d(tanθ)/dt times dt/dx cos²θ."""
    steepening = shape.s1 + t * (2.0 * shape.s2 + t * 3.0 * shape.s3)
    return steepening * (shape.q0 + t * (shape.q1 + t * shape.q2))


@kernel(inner=True, forceinline=True)
def bend_rate_at(shape: Shape, t: float) -> float:
    """Derivative of `bend_at` in t."""
    steepening = shape.s1 + t * (2.0 * shape.s2 + t * 3.0 * shape.s3)
    change = (2.0 * shape.s2 + t * 6.0 * shape.s3) * (shape.q0 + t * (shape.q1 + t * shape.q2))
    return change + steepening * (shape.q1 + 2.0 * t * shape.q2)


@kernel(inner=True, forceinline=True)
def stretch_at(shape: Shape, t: float) -> float:
    """1/cosθ at fraction t of the cell."""
    return shape.r0 + t * (shape.r1 + t * shape.r2)
