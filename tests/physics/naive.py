"""Slow and obvious twins of the physics kernels."""

from __future__ import annotations

import numpy as np

from avahazard.physics.cells import SPEEDS, Resistance
from avahazard.physics.runout_curve import JUMP_FACTOR, MU, RunoutCurve
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.physics.terrain import Terrain

G = 9.81


def legendre_coefficients(x, y, degree, penalty):
    """Solve the normal equations (AᵀA + λ BᵀB) c = Aᵀ y, B the second derivatives of A."""
    r = 2.0 * (x - x[0]) / (x[-1] - x[0]) - 1.0
    a, b = np.empty((len(x), degree + 1)), np.empty((len(x), degree + 1))
    for n in range(degree + 1):
        unit = np.zeros(n + 1)
        unit[n] = np.sqrt((2.0 * n + 1.0) / 2.0)
        a[:, n] = np.polynomial.legendre.legval(r, unit)
        b[:, n] = np.polynomial.legendre.legval(r, np.polynomial.legendre.legder(unit, 2))
    return np.linalg.solve(a.T @ a + penalty * b.T @ b, a.T @ y), a


def rate(mu, w, slope, second, curvature=1.0, factor=1.0, offset=0.0, constant=0.0, drag=0.0):
    """dw/dx where y' is `slope` and y'' is `second`: equation 2.3, term by term."""
    theta = -np.arctan(slope)
    kappa = second / (1.0 + slope**2) ** 1.5
    normal = np.maximum(0.0, G * np.cos(theta) + curvature * kappa * w)
    along = G * np.sin(theta) - (mu * factor + offset) * normal - constant - drag * w
    return 2.0 * along / np.cos(theta)


def small_steps(
    profile: SmoothProfile,
    release: float,
    mu: np.ndarray,
    terrain: Terrain | None = None,
    resistance: Resistance | None = None,
    step: float = 0.1,
):
    """x of the stop (nan: ran beyond the profile; the release: not released) and w at every step.

    The midpoint rule in x in steps of `step` m, resistance looked up where the block is.
    """
    x = release
    w = np.zeros(len(mu))
    stop = np.full(len(mu), np.nan)
    moving = np.ones(len(mu), dtype=bool)
    places, history = [x], [w.copy()]
    n = round((profile.x_max - release) / step)
    nodes = np.linspace(release, profile.x_max, 2 * n + 1)
    _, slopes, seconds = profile.derivatives(nodes)
    h = nodes[2] - nodes[0]

    def pull(k, place, w):
        if resistance is None or terrain is None:
            return rate(mu, w, slopes[k], seconds[k])
        cell = min(int(np.searchsorted(terrain.x, place, "right")) - 1, terrain.n_cells - 1)
        u = np.sqrt(np.maximum(w, 0.0))
        factor, constant = resistance.factor[cell], resistance.constant[cell]
        factor = factor * np.interp(u, SPEEDS, resistance.speed_factor)
        constant = constant + np.interp(u, SPEEDS, resistance.speed_constant)
        offset, drag = resistance.offset[cell], resistance.drag[cell]
        c = resistance.curvature
        return rate(mu, w, slopes[k], seconds[k], c, factor, offset, constant, drag)

    starts = pull(0, release, w) > 0.0
    stop[~starts], moving = release, starts.copy()
    for k in range(n):
        place = nodes[2 * k]
        half = w + 0.5 * h * pull(2 * k, place, w)
        new = w + h * pull(2 * k + 1, place + 0.5 * h, half)
        ends = moving & (new <= 0.0)
        stop[ends] = place + h * w[ends] / (w[ends] - new[ends])
        moving &= ~ends
        w = np.where(moving, new, 0.0)
        places.append(nodes[2 * k + 2])
        history.append(w.copy())
        if not moving.any():
            break
    return stop, np.array(places), np.array(history)


def first_zero(w0, d0, w1, d1, n=200_001):
    """First t in (0, 1] of a fine grid where the cubic is not above zero; nan if none."""
    t = np.linspace(0.0, 1.0, n)[1:]
    c2, c3 = 3.0 * (w1 - w0) - 2.0 * d0 - d1, d0 + d1 - 2.0 * (w1 - w0)
    below = np.flatnonzero(w0 + t * (d0 + t * (c2 + t * c3)) <= 0.0)
    return t[below[0]] if len(below) else np.nan


def naive_broken(x: np.ndarray, status: np.ndarray, cell: int) -> bool:
    """Whether one cell must not be interpolated, as the module says it in words."""
    if status[cell] != 0 or status[cell + 1] != 0:
        return True
    beside = []
    if cell > 0 and status[cell - 1] == 0:
        beside.append(abs(x[cell] - x[cell - 1]))
    if cell + 2 < len(x) and status[cell + 2] == 0:
        beside.append(abs(x[cell + 2] - x[cell + 1]))
    return bool(beside) and abs(x[cell + 1] - x[cell]) > JUMP_FACTOR * max(beside)


def naive_stop(curve: RunoutCurve, mu: float) -> tuple[float, float, int]:
    """Stop (x, y) and status of one friction on one curve."""
    last = len(curve.x) - 1
    cell = last - 1
    while cell > 0 and MU[cell] > mu:
        cell -= 1
    width = MU[cell + 1] - MU[cell]
    t = cell + min(max((mu - MU[cell]) / width, 0.0), 1.0)
    if naive_broken(curve.x, curve.status, cell):
        node = cell if t - cell < 0.5 else cell + 1
        return curve.x[node], curve.y[node], int(curve.status[node])
    share = t - cell
    return (
        (1.0 - share) * curve.x[cell] + share * curve.x[cell + 1],
        (1.0 - share) * curve.y[cell] + share * curve.y[cell + 1],
        0,
    )
