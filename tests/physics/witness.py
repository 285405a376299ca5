"""The third witness: scipy's integrator on equation 2.3 in time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from avahazard.physics.smooth_profile import SmoothProfile

G = 9.81


class Pieces(NamedTuple):
    """The profile's own polynomials: between `x[i]` and `x[i + 1]` in powers of t in [-1, 1]."""

    x: np.ndarray
    c: np.ndarray


def pieces(profile: SmoothProfile) -> Pieces:
    """Give the polynomials of a profile, so that the witness need not call Python for them."""
    degree = profile.degree or 3
    x = np.unique(np.concatenate([[profile.x_min, profile.x_max], profile.knots]))
    t = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    middle, half = 0.5 * (x[1:] + x[:-1]), 0.5 * np.diff(x)
    y = profile.derivatives(middle[:, None] + half[:, None] * t)[0]
    return Pieces(x, np.ascontiguousarray(np.linalg.solve(np.vander(t, increasing=True), y.T).T))


@njit(cache=True)
def motion(_time, state, path, mu, curvature, constant, drag):
    """dx/dt and du/dt."""
    x, u = state
    i = min(max(np.searchsorted(path.x, x, side="right") - 1, 0), len(path.c) - 1)
    half = 0.5 * (path.x[i + 1] - path.x[i])
    t = (x - path.x[i]) / half - 1.0
    slope, second = 0.0, 0.0
    for k in range(path.c.shape[1] - 1, 0, -1):
        slope = slope * t + k * path.c[i, k]
        if k > 1:
            second = second * t + k * (k - 1) * path.c[i, k]
    slope, second = slope / half, second / half**2
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, G * cos + curvature * second * cos**3 * u * u)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -G * slope * cos - mu * normal - constant - drag * u * u
    return out


def _at_rest(_time, state, *_):
    return state[1]


def _at_end(_time, state, path, *_):
    return state[0] - path.x[-1]


_at_rest.terminal, _at_rest.direction = True, -1.0
_at_end.terminal = True


def witness(path: Pieces, release, mu, curvature=1.0, constant=0.0, drag=0.0):
    """x of the stop (nan: ran beyond the profile), and x and speed of the integrator's steps."""
    run = solve_ivp(
        motion,
        (0.0, 1e5),
        [release, 0.0],
        method="DOP853",
        rtol=1e-10,
        atol=1e-9,
        events=[_at_rest, _at_end],
        args=(path, mu, curvature, constant, drag),
    )
    stopped = len(run.y_events[0]) > 0 and run.y_events[0][-1][0] < path.x[-1]
    return (run.y_events[0][-1][0] if stopped else np.nan), run.y[0], run.y[1]
