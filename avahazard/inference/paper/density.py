"""Holy's density of apparent friction (Ancey 2005, equations 2.4; Holy 1997, PRL 79, 3545).

The density is ψ², where ψ maximises Σ log ψ²(μ_i) less a penalty on ∫ψ'², under ∫ψ² = 1. Its Euler
equation is ψ'' = κ²ψ but for a source at each record of strength 1/ψ(μ_i), so that

    ψ(μ) = √κ Σ_i a_i exp(-κ|μ - μ_i|),    a_i ψ(μ_i) = m  (i = 1..N),    ∫ψ² = 1

N+1 equations for the a_i and the multiplier m. In units where m is 1 the first N say that the
gradient of the convex function ½ aᵀKa - Σ log a_i vanishes, K_ij = exp(-κ|μ_i - μ_j|): one solution
whatever κ and the ties, found by damped Newton. The last then only scales it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.kernels import kernel
from avahazard.records.errors import AvahazardError

DEFAULT_KAPPA = 5.0
MAX_NEWTON_STEPS = 200
N_FOLDS = 10
N_DENSITIES = 100
LEVELS = (0.05, 0.95)
FEWEST = 2


@dataclass(frozen=True, slots=True)
class HolyDensity:
    """ψ² by its sources: records `mu` and coefficients `a`, both [n_events], and κ (`kappa`)."""

    mu: Floats
    a: Floats
    kappa: float

    def psi(self, x: Floats) -> Floats:
        """ψ at x [n_points]."""
        distance = np.abs(np.asarray(x, np.float64)[:, None] - self.mu)
        return np.asarray(np.sqrt(self.kappa) * np.exp(-self.kappa * distance) @ self.a)

    def pdf(self, x: Floats) -> Floats:
        """The density ψ² at x [n_points]."""
        return self.psi(x) ** 2

    def extrapolated(self, x: Floats) -> Bools:
        """Where x [n_points] lies outside the records, and the density is a tail by assumption."""
        x = np.asarray(x, np.float64)
        return np.asarray((x < self.mu.min()) | (x > self.mu.max()))


def holy_density(mu: Floats, kappa: float = DEFAULT_KAPPA) -> HolyDensity:
    """Solves equations 2.4 for the records `mu` [n_events] (others than finite are left out).

    1/κ is the length over which one record spreads ψ. The default κ = 5 (a length of 0.2, where
    frictions range over 0.2 to 0.8) is the paper's and smooths strongly: one peak from whatever
    records. `choose_kappa` lets the data choose. Raises `AvahazardError` without records or with
    κ not positive.
    """
    mu = np.sort(np.asarray(mu, np.float64))
    mu = mu[np.isfinite(mu)]
    if mu.size == 0:
        raise AvahazardError("There is no apparent friction to make a density of.")
    if not (np.isfinite(kappa) and kappa > 0):
        raise AvahazardError(f"κ is {kappa}.", "It must be a positive number, such as 5.")
    a, solved = _solve(mu, float(kappa))
    if not solved:
        raise AvahazardError(
            "The friction density did not converge.", "Choose another κ; 5 is the paper's."
        )
    a /= np.sqrt(_integral(mu, a, kappa))
    return HolyDensity(mu, a, kappa)


def choose_kappa(mu: Floats) -> float:
    """The κ with the largest held-out likelihood in ten folds of the records `mu` [n_events].

    Equal records fall in one fold, since a record must not vouch for its copy. 24 values are
    tried, from one to two hundred per range of the records. With fewer than five different
    records there is nothing to choose by, and κ is 5.
    """
    mu = np.asarray(mu, np.float64)
    mu = mu[np.isfinite(mu)]
    values, group = np.unique(mu, return_inverse=True)
    if values.size < 5:
        return DEFAULT_KAPPA
    candidates = np.geomspace(1.0, 200.0, 24) / (values[-1] - values[0])
    fold = group % min(N_FOLDS, values.size)
    scores = [_held_out(mu, fold, float(kappa)) for kappa in candidates]
    return float(candidates[int(np.argmax(scores))])


def _held_out(mu: Floats, fold: Ints, kappa: float) -> float:
    total = 0.0
    for k in range(int(fold.max()) + 1):
        psi = holy_density(mu[fold != k], kappa).psi(mu[fold == k])
        total += float(np.sum(2.0 * np.log(np.maximum(psi, 1e-300))))
    return total


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


def _integral(mu: Floats, a: Floats, kappa: float) -> float:
    """∫ψ² over the line: Σ a_i a_j (1 + κd_ij) exp(-κd_ij)."""
    d = kappa * np.abs(mu[:, None] - mu)
    return float(a @ ((1.0 + d) * np.exp(-d)) @ a)


@kernel
def _solve(mu: Floats, kappa: float) -> tuple[Floats, bool]:
    """a > 0 with a_i Σ_j K_ij a_j = 1, of sorted `mu` [n_events]; and whether Newton got there.

    The minimum of ½ aᵀKa - Σ log a_i, a self-concordant function, so that steps of
    1/(1 + decrement) converge from anywhere. K is that of a first-order process: its products
    and the factors of K + diag(1/a²) are recursions along the sorted records (Foreman-Mackey et
    al. 2017, AJ 154, 220), stable with ties since a never exceeds 1.
    """
    n = mu.size
    decay = np.zeros(n)
    for i in range(1, n):
        decay[i] = math.exp(-kappa * (mu[i] - mu[i - 1]))
    a = 1.0 / np.sqrt(_times_kernel(decay, np.ones(n)))
    pivot, weight, step = np.empty(n), np.empty(n), np.empty(n)
    for _ in range(MAX_NEWTON_STEPS):
        gradient = _times_kernel(decay, a) - 1.0 / a
        carried, before = 0.0, 0.0
        for i in range(n):
            if i > 0:
                carried = decay[i] ** 2 * (carried + pivot[i - 1] * weight[i - 1] ** 2)
                before = decay[i] * (before + weight[i - 1] * step[i - 1])
            pivot[i] = 1.0 + 1.0 / a[i] ** 2 - carried
            weight[i] = (1.0 - carried) / pivot[i]
            step[i] = -gradient[i] - before
        step /= pivot
        after = 0.0
        for i in range(n - 2, -1, -1):
            after = decay[i + 1] * (after + step[i + 1])
            step[i] -= weight[i] * after
        decrement = math.sqrt(max(-(gradient * step).sum(), 0.0))
        a += step / (1.0 + decrement) if decrement > 0.25 else step
        if decrement < 1e-11:
            return a, True
    return a, False


@kernel(inner=True)
def _times_kernel(decay: Floats, a: Floats) -> Floats:
    """Ka in one pass each way."""
    result = a.copy()
    left, right = 0.0, 0.0
    for i in range(1, a.size):
        left = decay[i] * (left + a[i - 1])
        result[i] += left
    for i in range(a.size - 2, -1, -1):
        right = decay[i + 1] * (right + a[i + 1])
        result[i] += right
    return result
