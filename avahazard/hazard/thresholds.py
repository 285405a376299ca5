"""The friction under which a block exceeds a level: F(μ) and speeds turned round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.avalanches import Avalanches, Thresholds
from avahazard.physics.runout_curve import inverse

Floats = NDArray[np.float64]


def thresholds(
    avalanches: Avalanches,
    values: Sequence[Floats],
    flat: Sequence[NDArray[np.bool_]] | None = None,
) -> Thresholds:
    """The thresholds of what a block does, given for each group of draws over `MU`.

    `values` `[n_groups][n_classes, n_friction]` fall as friction rises, as stops and speeds do.
    Between the frictions of the grid they are straight, but for the cells
    `[n_groups][n_classes, n_friction - 1]` that are `flat`, where the nearer friction counts.
    """
    # Rounding may lift a value by an ulp over that of a lower friction.
    falling = [np.minimum.accumulate(v, axis=1) for v in values]
    members = [np.flatnonzero(avalanches.group == g) for g in range(len(values))]

    def find(level: Floats) -> Floats:
        mu = np.empty((avalanches.n_parameters, avalanches.n_classes))
        for g, mine in enumerate(members):
            if not len(mine):
                continue
            for c in range(avalanches.n_classes):
                jumps = None if flat is None else flat[g][c]
                mu[mine, c] = inverse(falling[g][c], jumps, level[mine])
        return mu

    return find


def stop_thresholds(avalanches: Avalanches) -> Thresholds:
    """The friction under which a block of each class runs past x (m)."""
    curves = [table.curve for table in avalanches.tables]
    return thresholds(
        avalanches, [np.where(c.left, np.inf, c.x) for c in curves], [c.broken for c in curves]
    )
