"""Slow, obvious twins of what `avahazard.physics` does to whole arrays."""

from __future__ import annotations

import numpy as np

from avahazard.physics.runout_curve import JUMP_FACTOR, RunoutCurve


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
    t = min(max((mu - curve.mu_min) / curve.mu_step, 0.0), float(last))
    cell = min(int(t), last - 1)
    if naive_broken(curve.x, curve.status, cell):
        node = cell if t - cell < 0.5 else cell + 1
        return curve.x[node], curve.y[node], int(curve.status[node])
    share = t - cell
    return (
        (1.0 - share) * curve.x[cell] + share * curve.x[cell + 1],
        (1.0 - share) * curve.y[cell] + share * curve.y[cell + 1],
        0,
    )
