"""Slow, obvious twins of the kernels of avahazard.hazard."""

from collections.abc import Callable

import numpy as np

from avahazard.hazard.exceedance import Avalanches, friction_below, yearly_rate
from avahazard.physics.runout_curve import MU, RunoutCurve


def naive_stop(curve: RunoutCurve, mu: float, jumps: set[int]) -> tuple[float, float]:
    """Stop (x, y) of one friction; `jumps` are the cells over which the stop jumps."""
    last = len(curve.status) - 1
    t = float(np.interp(mu, MU, np.arange(last + 1)))
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


def naive_inverse(curve: RunoutCurve, level: float) -> float:
    """Friction under which the block of one curve runs past x = `level` (m)."""
    x = np.minimum.accumulate(np.where(curve.left, np.inf, curve.x))
    over = np.flatnonzero(x > level)
    if not len(over):
        return 0.0
    if len(over) == len(x):
        return np.inf
    k = len(over) - 1
    part = 0.5
    if not curve.discontinuous[k] and np.isfinite(x[k]) and x[k] != x[k + 1]:
        part = (x[k] - level) / (x[k] - x[k + 1])
    return float(MU[k] + (MU[k + 1] - MU[k]) * part)


def rate_below(avalanches: Avalanches, mu: np.ndarray) -> np.ndarray:
    """Yearly rate `[n_parameters]` of friction under `mu` `[n_parameters, n_classes]`."""
    return yearly_rate(avalanches, friction_below(avalanches, mu[:, :, None]))


def naive_exceedance_rate(avalanches: Avalanches) -> Callable[[np.ndarray], np.ndarray]:
    """A function of x (m) `[n_parameters]`: the yearly rate of avalanches that stop beyond."""

    def rate(x: np.ndarray) -> np.ndarray:
        mu = [
            [naive_inverse(avalanches.curves[g][c], place) for c in range(avalanches.n_classes)]
            for g, place in zip(avalanches.group, x, strict=True)
        ]
        return rate_below(avalanches, np.array(mu))

    return rate
