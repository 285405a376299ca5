"""The error of a profile's points, and how far they want smoothing (docs/theory/motion.md).

Ground is taken as an integrated Wiener process: its second derivative is white noise of intensity
τ². The mean of such ground given points with errors σ_i is the cubic smoothing spline with the
penalty λ = 1/τ² (Wahba 1978), and second divided differences of the points know nothing of its
level and slope: their likelihood is the restricted one (REML), with a band of five as covariance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel

Source = Literal["given", "estimated", "assumed"]

FINEST_M = 0.1
"""An error that is not given is never taken as smaller: ground is grass and stones."""
FEWEST_POINTS = 15
"""Fewer points do not tell their error: it is taken as `FINEST_M`."""
DIFFERENCES = 4
"""Order of the differences that bound the error from above."""
VARIANCE_OF_DIFFERENCES = 5.26
"""n times the relative variance of the squared error by fourth differences: 2 Σ ρ²."""
N_WAVELENGTHS, N_SECTIONS = 40, 14
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class PointError:
    """Errors of the points `sigma` `[n_points]` (m), and the penalty λ on ∫ f''² that fits them.

    λ stands beside Σ ((y - f) / σ)², in m.
    """

    sigma: Floats
    source: Source
    penalty: float


def point_error(x: Floats, y: Floats, sigma: Floats | None = None) -> PointError:
    """The error of points (x, y) `[n_points]`, x strictly rising, and the smoothing they want.

    `sigma` `[n_points]` (m) is the error where it is known. Else it is that of the restricted
    likelihood, unless fourth differences show by two standard errors that it is less: ground of
    one wavelength, such as benches, is no Wiener process, and would pass for error (differences
    as a bound: Hall, Kay & Titterington 1990).
    """
    if sigma is not None:
        return PointError(sigma, "given", _best(x, y, sigma)[0])
    ones = np.ones(len(x))
    if len(x) < FEWEST_POINTS:
        sigma = FINEST_M * ones
        return PointError(sigma, "assumed", _best(x, y, sigma)[0])
    penalty, error = _best(x, y, None)
    differences, relative = difference_error(x, y)
    known = min(error, differences) if differences < (1.0 - 2.0 * relative) * error else error
    known = max(known, FINEST_M)
    if known != error:
        penalty = _best(x, y, known * ones)[0]
    return PointError(known * ones, "estimated", penalty)


def difference_error(x: Floats, y: Floats) -> tuple[float, float]:
    """The error (m) by fourth divided differences, and its relative standard error.

    Such differences are nought on any cubic; what ground adds makes it too large.
    """
    n = len(x) - DIFFERENCES
    place = np.arange(n)[:, None] + np.arange(DIFFERENCES + 1)
    apart = x[place][:, :, None] - x[place][:, None, :]
    # Scaled by the width of each window, so that no product runs out of range.
    apart /= (x[DIFFERENCES:] - x[:-DIFFERENCES])[:, None, None]
    apart[:, np.arange(DIFFERENCES + 1), np.arange(DIFFERENCES + 1)] = 1.0
    weight = 1.0 / np.prod(apart, axis=2)
    scaled = np.sum(weight * y[place], axis=1) / np.sqrt(np.sum(weight**2, axis=1))
    error = float(np.sqrt(np.mean(scaled**2)))
    return error, 0.5 * float(np.sqrt(VARIANCE_OF_DIFFERENCES / n))


def _best(x: Floats, y: Floats, sigma: Floats | None) -> tuple[float, float]:
    """The penalty of the largest restricted likelihood, and the common error where none is given.

    Searched over the wavelength that evenly spaced points would keep half of: from half their
    spacing, where the spline goes through the points, to four times the path, a straight line.
    """
    if len(x) < 3:
        return 1.0, FINEST_M
    given = np.ones(len(x)) if sigma is None else sigma
    errors, ground, z = _contrasts(x, y, given)
    length = float(x[-1] - x[0])
    density = float(np.sum(1.0 / given**2)) / length
    tiny = 1e-18 * float(np.ptp(y)) ** 2 + 1e-18

    def at(log_wavelength: float) -> tuple[float, float, float]:
        """Minus the log likelihood, penalty, error."""
        penalty = density * (np.exp(log_wavelength) / (2.0 * np.pi)) ** 4
        determinant, square = band_form(errors + ground / penalty, z)
        if sigma is not None:
            return 0.5 * (determinant + square), penalty, 1.0
        variance = square / len(z) + tiny
        return 0.5 * (determinant + len(z) * np.log(variance)), penalty, np.sqrt(variance)

    grid = np.linspace(np.log(0.5 * length / (len(x) - 1)), np.log(4.0 * length), N_WAVELENGTHS)
    k = int(np.argmin([at(w)[0] for w in grid]))
    low, high = float(grid[max(k - 1, 0)]), float(grid[min(k + 1, N_WAVELENGTHS - 1)])
    _, penalty, error = at(golden_section(lambda w: at(w)[0], low, high))
    # With a common error σ the penalty beside Σ (y - f)² is σ²/τ².
    return (float(penalty / error**2), float(error)) if sigma is None else (float(penalty), 1.0)


def golden_section(cost: Callable[[float], float], low: float, high: float) -> float:
    """Where `cost` is least between two places, to a thousandth of their distance."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = cost(left), cost(right)
    for _ in range(N_SECTIONS):
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = cost(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = cost(right)
    return 0.5 * (low + high)


@kernel
def band_form(band, z):  # type: ignore[no-untyped-def]
    """log |C| and z' C⁻¹ z of a covariance C of band five; inf and 0 where it is not positive.

    `band` `[3, n]` holds its upper diagonals as LAPACK keeps them, `z` is `[n]`. C = L D L', which
    one pass down the diagonal gives: LAPACK calls two routines for each of its rows.
    """
    determinant, square = 0.0, 0.0
    d1, d2 = 1.0, 1.0  # D one and two rows above
    w1, w2 = 0.0, 0.0  # L⁻¹ z there
    beside = 0.0  # L one row above, beside its diagonal
    for i in range(len(z)):
        far = band[0, i] / d2 if i > 1 else 0.0
        near = (band[1, i] - far * d2 * beside) / d1 if i > 0 else 0.0
        d = band[2, i] - near * near * d1 - far * far * d2
        if not d > 0.0:
            return np.inf, 0.0
        w = z[i] - near * w1 - far * w2
        determinant += np.log(d)
        square += w * w / d
        d2, d1, w2, w1, beside = d1, d, w1, w, near
    return determinant, square


def _contrasts(x: Floats, y: Floats, sigma: Floats) -> tuple[Floats, Floats, Floats]:
    """Covariance of second divided differences by the errors and by ground (τ = 1), and these.

    Upper bands `[3, n_points - 2]` as LAPACK keeps them; the differences `[n_points - 2]`.
    """
    h = np.diff(x)
    n = len(x) - 2
    a, c = 1.0 / h[:-1], 1.0 / h[1:]
    b = -(a + c)
    v = sigma**2
    errors, ground = np.zeros((3, n)), np.zeros((3, n))
    errors[2] = a**2 * v[:-2] + b**2 * v[1:-1] + c**2 * v[2:]
    errors[1, 1:] = b[:-1] * a[1:] * v[1:-2] + c[:-1] * b[1:] * v[2:-1]
    errors[0, 2:] = c[:-2] * a[2:] * v[2:-2]
    ground[2] = (h[:-1] + h[1:]) / 3.0
    ground[1, 1:] = h[1:-1] / 6.0
    return errors, ground, np.diff(np.diff(y) / h)
