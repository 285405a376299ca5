"""Derivatives of log μ by the coordinates of each law, `[n_coordinates, n_events]`.

At coordinates u `[n_coordinates]` and volumes (m3) `[n_events]`; 0 where log μ is at its bounds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avahazard.inference.model.law_curves import (
    MOST_LOG,
    N_SCALE,
    bounded_exp,
    in_millions,
    log_in_c,
)

Array = NDArray[np.float64]


def exponential_slopes(u: Array, volume: Array) -> Array:
    """Of log a - n V."""
    x = in_millions(volume)
    with np.errstate(over="ignore"):  # beyond the bounds then
        return _inside(u[0] - u[1] * x, np.ones_like(x), -x)


def power_slopes(u: Array, volume: Array) -> Array:
    """Of log α - β log V."""
    x = np.log(volume)
    return _inside(u[0] - u[1] * x, np.ones_like(x), -x)


def rational_slopes(u: Array, volume: Array) -> Array:
    """Of log a - log(1 + (V/c)^n)."""
    n = float(bounded_exp(u[2]))
    bend = n * (log_in_c(volume) - u[1])
    share = expit(bend)
    log_mu = u[0] - np.logaddexp(0.0, bend)
    return _inside(log_mu, np.ones_like(bend), n * share, -bend * share)


def asymptotic_slopes(u: Array, volume: Array) -> Array:
    """Of log a + log(e^(-nV) + (1 - e^(-nV)) μ∞/a)."""
    reach = bounded_exp(u[2] + np.log(volume) + np.log(N_SCALE))
    limit, still = float(bounded_exp(u[1])), np.exp(-reach)
    fallen = -limit * np.expm1(-reach)
    share = still + fallen
    by_reach = still * (limit - 1.0) * reach / share
    return _inside(u[0] + np.log(share), np.ones_like(reach), fallen / share, by_reach)


def constant_slopes(u: Array, volume: Array) -> Array:
    """Of log a."""
    return _inside(u[0] + np.zeros_like(volume), np.ones_like(volume))


def _inside(log_mu: Array, *slopes: Array) -> Array:
    return np.where(np.abs(log_mu) < MOST_LOG, np.stack(slopes), 0.0)
