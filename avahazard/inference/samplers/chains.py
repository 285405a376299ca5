"""Draws of named parameters, and whether their chains have converged.

By rank-normalised split R-hat and effective sample sizes.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

RHAT_LIMIT = 1.01
ESS_LIMIT = 400.0
TAIL_PROBABILITY = (0.05, 0.95)
STUCK_ACCEPTANCE = 0.01


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """The worst figures over the parameters; `converged` only when all of them pass."""

    rhat_max: float
    ess_bulk_min: float
    ess_tail_min: float
    acceptance: float
    stuck_chains: int
    converged: bool


def diagnose_chains(
    draws: NDArray[np.float64], acceptance: NDArray[np.float64] | None = None
) -> Diagnostics:
    """R-hat, bulk and tail ESS (Vehtari et al. 2021) and stuck chains.

    `draws` is [n_chains, n_draws, n_parameters], `acceptance` [n_chains] (None: every draw is
    accepted, as in Gibbs). A parameter with one value in all chains is a constant and is left
    out. A chain is stuck when one of the other parameters never moves in it, or when it accepts
    less than 1 % of its proposals. With a stuck chain or a draw that is not finite, R-hat is
    infinite and the ESS 0.
    """
    n_chains = draws.shape[0]
    rates = np.ones(n_chains) if acceptance is None else np.asarray(acceptance, dtype=np.float64)
    low, high = draws.min(axis=1), draws.max(axis=1)
    free = low.min(axis=0) != high.max(axis=0)
    stuck = np.any((low == high)[:, free], axis=1) | (rates < STUCK_ACCEPTANCE)
    n_stuck = int(stuck.sum())
    mean_rate = float(rates.mean())
    if n_stuck or not np.isfinite(draws).all():
        return Diagnostics(float("inf"), 0.0, 0.0, mean_rate, n_stuck, False)
    if not free.any():
        n = float(draws.shape[0] * draws.shape[1])
        return Diagnostics(1.0, n, n, mean_rate, 0, True)
    rhat, bulk, tail = _worst(draws[:, :, free])
    converged = rhat < RHAT_LIMIT and bulk >= ESS_LIMIT and tail >= ESS_LIMIT
    return Diagnostics(rhat, bulk, tail, mean_rate, 0, converged)


def _worst(draws: NDArray[np.float64]) -> tuple[float, float, float]:
    array_stats = import_module("arviz_stats.base").array_stats  # slow to import, so only here
    ary = np.moveaxis(draws, 2, 0)
    rhat = array_stats.rhat(ary)
    bulk = array_stats.ess(ary, method="bulk")
    tail = array_stats.ess(ary, method="tail", prob=TAIL_PROBABILITY)
    return float(np.max(rhat)), float(np.min(bulk)), float(np.min(tail))


@dataclass(frozen=True, slots=True)
class Chains:
    """`draws` is [n_chains, n_draws, n_parameters], in the order and units of `names`, `units`."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    draws: NDArray[np.float64]
    acceptance: NDArray[np.float64]
    diagnostics: Diagnostics

    def pooled(self) -> NDArray[np.float64]:
        """All chains in a row, [n_chains * n_draws, n_parameters]."""
        return self.draws.reshape(-1, self.draws.shape[2])


def chains(
    names: tuple[str, ...],
    units: tuple[str, ...],
    draws: NDArray[np.float64],
    acceptance: NDArray[np.float64] | None = None,
) -> Chains:
    """`Chains` with their diagnostics; without `acceptance` every draw is accepted."""
    rates = np.ones(draws.shape[0]) if acceptance is None else acceptance
    return Chains(names, units, draws, rates, diagnose_chains(draws, rates))
