"""The paper's perturbation check: records moved within their errors, and the spread this causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.laws import Law
from avahazard.inference.paper.apparent import SEVERAL, bracket
from avahazard.inference.paper.least_squares import fit_law
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
from avahazard.physics.block import STOPPED
from avahazard.physics.runout_curve import RunoutCurve

Array = NDArray[np.float64]

ENOUGH = 0.5  # share of replicates with a friction below which no spread is given


@dataclass(frozen=True, slots=True)
class Perturbation:
    """`mu` [n_replicates, n_events], nan where no friction stops at the moved record.

    `mu_sd` [n_events] is its spread, nan where fewer than half of the replicates have a friction.
    """

    mu: Array
    mu_sd: Array

    def law_spread(self, law: Law, volume: Array) -> tuple[Array, Array]:
        """Mean and sd [n_parameters] of the law's parameters, refitted to every replicate.

        `volume` [n_events] in m3. Raises `AvahazardError` when there are too few events.
        """
        fitted = np.array([fit_law(law, volume, mu).parameters for mu in self.mu])
        return fitted.mean(axis=0), fitted.std(axis=0, ddof=1)


def perturb(
    runout: Array,
    runout_sigma: Array,
    table: NDArray[np.int64],
    stop_y: Array,
    curves: RunoutCurve,
    *,
    seed: int,
    n_replicates: int = 200,
) -> Perturbation:
    """Apparent friction of `n_replicates` sets of records, each moved by its normal error.

    `runout`, `runout_sigma` [n_events] in m; the curves as in `apparent_friction`.
    """
    runout, runout_sigma = np.asarray(runout, np.float64), np.asarray(runout_sigma, np.float64)
    noise = generator(seed, "perturbation").standard_normal((n_replicates, runout.size))
    moved = runout + runout_sigma * noise
    stopped = curves.status == STOPPED
    mu = _invert(moved, np.asarray(table), stop_y, stopped, curves.broken, curves.mu)
    mu_sd = np.full(runout.size, np.nan)
    for i in range(runout.size):
        found = mu[np.isfinite(mu[:, i]), i]
        if found.size > 1 and found.size >= ENOUGH * n_replicates:
            mu_sd[i] = found.std(ddof=1)
    return Perturbation(mu, mu_sd)


@kernel
def _invert(
    runout: Array,
    table: NDArray[np.int64],
    stop_y: Array,
    stopped: NDArray[np.bool_],
    broken: NDArray[np.bool_],
    grid: Array,
) -> Array:
    mu = np.full(runout.shape, np.nan)
    for r in range(runout.shape[0]):
        for i in range(runout.shape[1]):
            k = table[i]
            low, high, code = bracket(runout[r, i], stop_y[k], stopped[k], broken[k], grid)
            if code <= SEVERAL:
                mu[r, i] = 0.5 * (low + high)
    return mu
