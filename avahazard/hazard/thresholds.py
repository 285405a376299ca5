"""The friction under which a block exceeds a level: F(μ) and speeds turned round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.avalanches import Avalanches, Thresholds
from avahazard.hazard.runout_curve import broken_cells
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_table import MU, MU_STEP

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
    rising = [-np.minimum.accumulate(v, axis=1) for v in values]
    members = [np.flatnonzero(avalanches.group == g) for g in range(len(values))]

    def find(level: Floats) -> Floats:
        mu = np.empty((avalanches.n_parameters, avalanches.n_classes))
        for g, mine in enumerate(members):
            if not len(mine):
                continue
            for c in range(avalanches.n_classes):
                jumps = None if flat is None else flat[g][c]
                mu[mine, c] = _friction_at(rising[g][c], jumps, level[mine])
        return mu

    return find


def stop_thresholds(avalanches: Avalanches) -> Thresholds:
    """The friction under which a block of each class runs past x (m)."""
    values = [stops(table) for table in avalanches.tables]
    flat = [
        np.array([broken_cells(x, status) for x, status in zip(v, table.status, strict=True)])
        for v, table in zip(values, avalanches.tables, strict=True)
    ]
    return thresholds(avalanches, values, flat)


def stops(table: Predicted) -> Floats:
    """x of the stop `[n_classes, n_friction]`, inf where the profile was left."""
    return np.where(table.status == LEFT_PROFILE, np.inf, table.x)


def _friction_at(rising: Floats, flat: NDArray[np.bool_] | None, level: Floats) -> Floats:
    """Friction `[n]` under which a value exceeds `level` `[n]`; `rising` is its negative."""
    # The first friction of the grid at which the level is not exceeded.
    first = np.searchsorted(rising, -level, side="left")
    last = np.clip(first - 1, 0, len(rising) - 2)
    above, below = -rising[last], -rising[last + 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        part = (above - level) / (above - below)
    broken = ~np.isfinite(part) if flat is None else ~np.isfinite(part) | flat[last]
    part = np.where(broken, 0.5, part)
    mu = MU[0] + MU_STEP * (last + part)
    return np.where(first == 0, 0.0, np.where(first == len(rising), np.inf, mu))
