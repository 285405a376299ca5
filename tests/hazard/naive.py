"""Slow, obvious twins of the kernels of avahazard.hazard."""

import numpy as np

from avahazard.physics.runout_curve import RunoutCurve


def naive_stop(curve: RunoutCurve, mu: float, jumps: set[int]) -> tuple[float, float]:
    """Stop (x, y) of one friction; `jumps` are the cells over which the stop jumps."""
    t = (mu - curve.mu_min) / curve.mu_step
    last = len(curve.status) - 1
    nearest = min(max(round(t), 0), last)
    cell = int(np.floor(t))
    if 0 <= cell < last and cell not in jumps and curve.status[cell : cell + 2].tolist() == [0, 0]:
        weight = t - cell
        return tuple(
            (1 - weight) * stop[cell] + weight * stop[cell + 1] for stop in (curve.x, curve.y)
        )
    if curve.status[nearest] == 1:
        return np.inf, -np.inf
    return curve.x[nearest], curve.y[nearest]
