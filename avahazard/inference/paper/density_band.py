"""What the errors of the records do to the density of friction (Ancey 2005, section 2a)."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.paper.density import holy_density

N_DENSITIES = 100
LEVELS = (0.05, 0.95)
FEWEST = 2


def density_band(moved: Floats, x: Floats, kappa: float) -> Floats:
    """5 and 95 % `[2, n_points]` of Holy's density at x `[n_points]` under moved records.

    `moved` `[n_replicates, n_events]` are apparent frictions of records moved within their
    errors, nan where no friction stops there; the first `N_DENSITIES` are used. nan where fewer
    than two frictions are left in each.
    """
    densities = [
        holy_density(mu[np.isfinite(mu)], kappa).pdf(x)
        for mu in moved[:N_DENSITIES]
        if np.sum(np.isfinite(mu)) >= FEWEST
    ]
    if not densities:
        return np.full((2, len(x)), np.nan)
    return np.asarray(np.quantile(densities, LEVELS, axis=0))
