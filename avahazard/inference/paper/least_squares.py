"""Least squares of the friction laws on (volume, apparent friction), with covariance."""

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.laws import LAWS, Law, differences, usable
from avahazard.records.errors import AvahazardError

EQUAL = 0.01
"""Volumes this near to each other (of one) are the same to a fit."""
WILDEST = 1e100
"""An optimiser's step is cut there."""
SINGULAR, WIDEST = 1e-9, 10.0
"""A constant is free where its standard error is so many of its (weak) prior's, or has no end."""
MOST_STEPS = 400
FIGURE_1 = np.array([0.555, 0.814, 68883.0, 1.85])  # the paper's rational law: a, b, c in m3, n


@dataclass(frozen=True, slots=True)
class LawFit:
    """A fitted law: natural parameters [n_parameters] and their covariance, r² and AIC."""

    law: Law
    parameters: Floats
    covariance: Floats
    r2: float
    aic: float

    @property
    def standard_errors(self) -> Floats:
        """Standard errors [n_parameters]."""
        return np.sqrt(np.diag(self.covariance))


def fit_law(law: Law, volume: Floats, mu: Floats) -> LawFit:
    """The law nearest to the points (V, μ) in the sum of squares of μ.

    `volume` [n_events] in m3 and `mu` [n_events]; pairs that are not finite and positive are left
    out. The covariance is s² (JᵀJ)⁺ with s² the residual variance. The rational law's data fix
    a/b, c b^(1/n) and n only; of the equal (a, b, c, n) the one nearest to the paper's figure 1 in
    logarithms is given (the minimum-norm step from there), and the pseudo-inverse is the covariance
    of that choice. AIC counts the identifiable constants and the variance. Raises
    `AvahazardError` when there are fewer points than constants plus one, fewer volumes than
    constants, or when the points do not fix the constants.
    """
    volume, mu = usable(volume, mu)
    n_free = len(law.coordinates)
    if mu.size <= n_free:
        raise AvahazardError(
            f"The {law.name} law needs at least {n_free + 1} events with a volume and a friction; "
            f"there {'is' if mu.size == 1 else 'are'} {mu.size or 'none'}.",
            "Import more events, or take a law with fewer constants.",
        )
    different = 1 + int(np.sum(np.diff(np.sort(np.log(volume))) > EQUAL))
    if law.uses_volume and different < n_free:
        raise AvahazardError(
            f"The {law.name} law needs events of at least {n_free} different volumes; there "
            + ("is 1: all volumes are equal." if different == 1 else f"are {different}."),
            "Import events of other volumes, or take a law with fewer constants.",
        )
    try:
        fit = _fit(law, volume, mu)
    except np.linalg.LinAlgError:
        fit = None
    if fit is None or not np.isfinite([*fit.parameters, *fit.covariance.ravel(), fit.aic]).all():
        raise AvahazardError(
            f"The {law.name} law is left out: these {mu.size} events do not fix its constants.",
            "Take a law with fewer constants.",
        )
    return fit


def fit_every_law(volume: Floats, mu: Floats) -> tuple[list[LawFit], list[str]]:
    """Fits of all laws that the points (V, μ) `[n_events]` support, and why others are absent."""
    fits, notes = [], []
    for law in LAWS.values():
        try:
            fits.append(fit_law(law, volume, mu))
        except AvahazardError as error:
            notes.append(error.message)
    return fits, notes


def _fit(law: Law, volume: Floats, mu: Floats) -> LawFit | None:
    """The fit; None where the points leave a constant free."""
    from scipy.optimize import least_squares  # noqa: PLC0415 (slow to import)

    n_free = len(law.coordinates)

    def residuals(u: Floats) -> Floats:
        # Squares of what is wildly off must not overflow.
        bounded = np.clip(u, -WILDEST, WILDEST)
        return np.exp(law.log_friction(bounded, volume)) - mu

    starts = [law.start(volume, mu)]
    if law.name == "rational":
        starts.append(law.from_natural(FIGURE_1))
    fits = [
        least_squares(residuals, u, method="lm", xtol=1e-14, ftol=1e-14, max_nfev=MOST_STEPS)
        for u in starts
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    u = np.asarray(best.x, np.float64)
    squares = 2.0 * float(best.cost)
    total = float(np.sum((mu - mu.mean()) ** 2))
    if squares > (1.0 + 1e-9) * total + 1e-12:
        return None  # stuck: every law can be flat
    if _is_free(law, u, volume, float(np.sqrt(squares / (mu.size - n_free)))):
        return None
    natural = law.to_natural(u)
    if law.name == "rational":
        natural = _nearest_on_ridge(natural)
    covariance = _covariance(law, natural, volume) * squares / (mu.size - n_free)
    r2 = 1.0 - squares / total if total > 0 else 0.0
    aic = mu.size * np.log(max(squares / mu.size, 1e-300)) + 2.0 * (n_free + 1)
    return LawFit(law, natural, covariance, float(r2), float(aic))


def _is_free(law: Law, u: Floats, volume: Floats, noise: float) -> bool:
    """Whether some direction of the coordinates moves the curve at the points too little.

    That is where its standard error is `WIDEST` prior standard deviations and more; `noise` is
    the residuals' standard deviation.
    """
    if not np.isfinite(u).all():
        return True
    moved = differences(lambda at: np.exp(law.log_friction(at, volume)), u, law.prior_sd)
    values = np.linalg.svd(moved, compute_uv=False)
    return bool(values[-1] <= SINGULAR * values[0] or noise >= WIDEST * values[-1])


def _nearest_on_ridge(natural: Floats) -> Floats:
    """Of (k a, k b, k^(-1/n) c, n), k > 0, the one nearest to figure 1 in logarithms."""
    step = np.array([1.0, 1.0, -1.0 / natural[3], 0.0])
    log_k = step @ (np.log(FIGURE_1) - np.log(natural)) / (step @ step)
    return np.asarray(natural * np.exp(step * log_k), np.float64)


def _covariance(law: Law, natural: Floats, volume: Floats) -> Floats:
    """(JᵀJ)⁺ of the natural parameters, by central differences with relative steps."""
    scale = np.where(natural != 0, np.abs(natural), law.to_natural(law.prior_mean + 1.0))
    slopes = differences(lambda at: law.friction(at, volume), natural, scale)
    inverse = np.linalg.pinv(slopes.T, rcond=1e-7)
    return np.asarray((inverse @ inverse.T) * np.outer(scale, scale), np.float64)
