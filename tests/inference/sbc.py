"""The judge of simulation-based calibration (Talts et al. 2018).

Parameters are drawn from the prior, records from the model, and the rank of each true parameter
among its posterior draws is uniform if prior, simulation, likelihood and sampler agree. Ranks are
judged by the greatest departure of their distribution function (Säilynoja et al. 2022).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy import stats

N_WORLDS, N_DRAWS = 100, 99
LEVEL = 0.01
"""Chance that a case whose ranks are uniform is blamed: each of its parameters has its share."""


def rank(draws: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Ranks `[n_slots]` of the truth among `N_DRAWS` of the draws `[n, n_slots]`."""
    thinned = draws[np.linspace(0, len(draws) - 1, N_DRAWS).round().astype(int)]
    return np.asarray(np.sum(thinned < truth, axis=0))


def departure(ranks: np.ndarray) -> float:
    """The least likely count of ranks up to any value, as a tail probability."""
    n, values = len(ranks), np.arange(N_DRAWS)
    counts = np.sum(ranks[:, None] <= values, axis=0)
    share = (values + 1.0) / (N_DRAWS + 1.0)
    tails = np.minimum(stats.binom.cdf(counts, n, share), stats.binom.sf(counts - 1, n, share))
    return float(tails.min())


@cache
def _null(n_worlds: int) -> np.ndarray:
    """Departures of ranks that are uniform indeed."""
    rng = np.random.default_rng(1)
    return np.array([departure(rng.integers(0, N_DRAWS + 1, n_worlds)) for _ in range(4000)])


def p_value(ranks: np.ndarray) -> float:
    """Chance of a departure as great, were the ranks `[n_worlds]` uniform."""
    return float(np.mean(_null(len(ranks)) <= departure(ranks)))


def least_p(names: list[str], ranks: np.ndarray) -> float:
    """The least p-value of all parameters, times their number; prints each."""
    found = {name: p_value(ranks[:, k]) for k, name in enumerate(names)}
    print({name: round(p, 3) for name, p in found.items()})
    return min(found.values()) * len(names)
