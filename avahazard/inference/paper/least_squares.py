"""Least squares of the friction laws on (volume, apparent friction), with covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.laws import Law
from avahazard.records.errors import AvahazardError

Array = NDArray[np.float64]

FIGURE_1 = np.array([0.555, 0.814, 68883.0, 1.85])  # the paper's rational law: a, b, c in m3, n


@dataclass(frozen=True, slots=True)
class LawFit:
    """A fitted law: natural parameters [n_parameters] and their covariance, r² and AIC."""

    law: Law
    parameters: Array
    covariance: Array
    r2: float
    aic: float

    @property
    def standard_errors(self) -> Array:
        """Standard errors [n_parameters]."""
        result: Array = np.sqrt(np.diag(self.covariance))
        return result


def fit_law(law: Law, volume: Array, mu: Array) -> LawFit:
    """The law nearest to the points (V, μ) in the sum of squares of μ.

    `volume` [n_events] in m3 and `mu` [n_events]; pairs that are not finite and positive are left
    out. The covariance is s² (JᵀJ)⁺ with s² the residual variance. The rational law's data fix
    a/b, c b^(1/n) and n only; of the equal (a, b, c, n) the one nearest to the paper's figure 1 in
    logarithms is given (the minimum-norm step from there), and the pseudo-inverse is the covariance
    of that choice. AIC counts the identifiable constants and the variance. Raises
    `AvahazardError` when there are fewer points than constants plus one.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 (slow to import)

    volume, mu = np.asarray(volume, np.float64), np.asarray(mu, np.float64)
    keep = np.isfinite(volume) & np.isfinite(mu) & (volume > 0) & (mu > 0)
    volume, mu = volume[keep], mu[keep]
    n_free = len(law.coordinates)
    if mu.size <= n_free:
        raise AvahazardError(
            f"The {law.name} law needs at least {n_free + 1} events with a volume and a friction; "
            f"there are {mu.size}.",
            "Import more events, or take a law with fewer constants.",
        )

    def residuals(u: Array) -> Array:
        log_mu = np.minimum(law.log_friction(u, volume), 50.0)
        result: Array = np.exp(log_mu) - mu
        return result

    starts = [law.start(volume, mu)]
    if law.name == "rational":
        starts.append(law.from_natural(FIGURE_1))
    fits = [least_squares(residuals, u, method="lm", xtol=1e-14, ftol=1e-14) for u in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    natural = law.to_natural(np.asarray(best.x, np.float64))
    if law.name == "rational":
        natural = _nearest_on_ridge(natural)
    squares = 2.0 * float(best.cost)
    covariance = _covariance(law, natural, volume) * squares / (mu.size - n_free)
    total = float(np.sum((mu - mu.mean()) ** 2))
    r2 = 1.0 - squares / total if total > 0 else 0.0
    aic = mu.size * np.log(max(squares / mu.size, 1e-300)) + 2.0 * (n_free + 1)
    return LawFit(law, natural, covariance, float(r2), float(aic))


def _nearest_on_ridge(natural: Array) -> Array:
    """Of (k a, k b, k^(-1/n) c, n), k > 0, the one nearest to figure 1 in logarithms."""
    step = np.array([1.0, 1.0, -1.0 / natural[3], 0.0])
    log_k = step @ (np.log(FIGURE_1) - np.log(natural)) / (step @ step)
    return np.asarray(natural * np.exp(step * log_k), np.float64)


def _covariance(law: Law, natural: Array, volume: Array) -> Array:
    """(JᵀJ)⁺ of the natural parameters, by central differences.

    Steps are relative, so that the pseudo-inverse compares numbers of one size.
    """
    scale = np.where(natural != 0, np.abs(natural), law.to_natural(law.prior_mean + 1.0))
    columns = []
    for k in range(natural.size):
        step = np.zeros_like(natural)
        step[k] = 1e-5 * scale[k]
        difference = law.friction(natural + step, volume) - law.friction(natural - step, volume)
        columns.append(difference / 2e-5)
    inverse = np.linalg.pinv(np.stack(columns, axis=1), rcond=1e-7)
    return np.asarray((inverse @ inverse.T) * np.outer(scale, scale), np.float64)
