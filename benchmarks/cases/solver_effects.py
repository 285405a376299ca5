"""The rival of `run_effects` and `run_speed`: the motion with drag, forest and speed-weakening."""

from __future__ import annotations

import numpy as np
from numba import njit

from benchmarks.cases.solver import GRAVITY, ground


@njit
def motion(_time, state, breaks, c, mu, drag, forest, ratio, half_speed):  # type: ignore[no-untyped-def]
    """dx/dt and du/dt: `forest` is (from x, to x, drag there), friction falls to `ratio` of it."""
    x, u = state
    slope, second = ground(x, breaks, c)
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, GRAVITY * cos + second * cos**3 * u * u)
    share = ratio + (1.0 - ratio) / (1.0 + max(u, 0.0) / half_speed)
    brake = drag + (forest[2] if forest[0] <= x < forest[1] else 0.0)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -GRAVITY * slope * cos - mu * share * normal - brake * u * u
    return out
