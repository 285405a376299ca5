"""The rival of `run`: scipy's solve_ivp in time, with a compiled right-hand side."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

GRAVITY = 9.81


def pieces(profile):  # type: ignore[no-untyped-def]
    """Breaks of the profile and its polynomials between them, in powers of t in [-1, 1]."""
    degree = profile.degree or 3
    x = np.unique(np.concatenate([[profile.x_min, profile.x_max], profile.knots]))
    t = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    middle, half = 0.5 * (x[1:] + x[:-1]), 0.5 * np.diff(x)
    y = profile.derivatives(middle[:, None] + half[:, None] * t)[0]
    return x, np.ascontiguousarray(np.linalg.solve(np.vander(t, increasing=True), y.T).T)


@njit
def ground(x, breaks, c):  # type: ignore[no-untyped-def]
    """First and second derivative of the profile at x."""
    i = min(max(np.searchsorted(breaks, x, side="right") - 1, 0), len(c) - 1)
    half = 0.5 * (breaks[i + 1] - breaks[i])
    t = (x - breaks[i]) / half - 1.0
    slope, second = 0.0, 0.0
    for k in range(c.shape[1] - 1, 0, -1):
        slope = slope * t + k * c[i, k]
        if k > 1:
            second = second * t + k * (k - 1) * c[i, k]
    return slope / half, second / half**2


@njit
def motion(_time, state, breaks, c, mu):  # type: ignore[no-untyped-def]
    """dx/dt and du/dt of equation 2.3."""
    x, u = state
    slope, second = ground(x, breaks, c)
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, GRAVITY * cos + second * cos**3 * u * u)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -GRAVITY * slope * cos - mu * normal
    return out


def at_rest(_time, state, *_):  # type: ignore[no-untyped-def]
    return state[1]


def at_end(_time, state, breaks, *_):  # type: ignore[no-untyped-def]
    return state[0] - breaks[-1]


at_rest.terminal, at_rest.direction = True, -1.0  # type: ignore[attr-defined]
at_end.terminal = True  # type: ignore[attr-defined]


def solve(path, release, rtol, *resisting, motion=motion):  # type: ignore[no-untyped-def]
    """x where the block stops, or the end of the path; `resisting` is what the motion takes."""
    found = solve_ivp(
        motion,
        (0.0, 1e5),
        [release, 0.0],
        method="DOP853",
        rtol=rtol,
        atol=1e-9,
        events=[at_rest, at_end],
        args=(*path, *resisting),
    )
    return found.y[0, -1]
