"""The rival of `run_effects` and `run_speed`: solve_ivp with drag, forest and speed-weakening."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from benchmarks.cases.solver import GRAVITY


@njit
def motion(_time, state, breaks, c, mu, drag, forest, ratio, half_speed):  # type: ignore[no-untyped-def]
    """dx/dt and du/dt: `forest` is (from x, to x, drag there), friction falls to `ratio` of it."""
    x, u = state
    i = min(max(np.searchsorted(breaks, x, side="right") - 1, 0), len(c) - 1)
    half = 0.5 * (breaks[i + 1] - breaks[i])
    t = (x - breaks[i]) / half - 1.0
    slope, second = 0.0, 0.0
    for k in range(c.shape[1] - 1, 0, -1):
        slope = slope * t + k * c[i, k]
        if k > 1:
            second = second * t + k * (k - 1) * c[i, k]
    slope, second = slope / half, second / half**2
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, GRAVITY * cos + second * cos**3 * u * u)
    share = ratio + (1.0 - ratio) / (1.0 + max(u, 0.0) / half_speed)
    brake = drag + (forest[2] if forest[0] <= x < forest[1] else 0.0)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -GRAVITY * slope * cos - mu * share * normal - brake * u * u
    return out


def at_rest(_time, state, *_):  # type: ignore[no-untyped-def]
    return state[1]


def at_end(_time, state, breaks, *_):  # type: ignore[no-untyped-def]
    return state[0] - breaks[-1]


at_rest.terminal, at_rest.direction = True, -1.0  # type: ignore[attr-defined]
at_end.terminal = True  # type: ignore[attr-defined]


def solve(path, release, mu, rtol, drag, forest, ratio, half_speed):  # type: ignore[no-untyped-def]
    """x where the block stops, or the end of the path."""
    found = solve_ivp(
        motion,
        (0.0, 1e5),
        [release, 0.0],
        method="DOP853",
        rtol=rtol,
        atol=1e-9,
        events=[at_rest, at_end],
        args=(*path, mu, drag, forest, ratio, half_speed),
    )
    return found.y[0, -1]
