"""The error of a profile's points, and how far they want smoothing (docs/theory/motion.md).

The penalty of the spline is λ = 1/τ². Second divided differences of the points know nothing of
level and slope: their likelihood is the restricted one (REML), with a band of five as covariance.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from avahazard.arrays import Floats
from avahazard.kernels import kernel

ROWS_A_LOG = 8
"""Rows whose pivots are multiplied before a log is taken."""


@kernel
def band_forms(errors: Floats, ground: Floats, z: Floats, share: Floats) -> Floats:
    """log |C| and z' C⁻¹ z `[2, n_shares]` of C = `errors` + share `ground`, for each share.

    `errors`, `ground` `[3, n]` hold upper diagonals as LAPACK keeps them, 0 before these begin, `z`
    is `[n]`. inf and 0 where C is not positive. C = L D L', which one pass down the diagonal gives.
    """
    n_shares = len(share)
    # What is carried from row to row, of all shares, in one array: so the compiler sees that its
    # parts lie apart, and they go through in vectors. `beside` is of L, `white` is L⁻¹ z.
    carried = np.zeros((10, n_shares))
    carried[5:] = 1.0
    log, square, beside, white, white_above = carried[:5]
    pivot, one_over, one_over_above, product, least = carried[5:]
    for i in range(len(z)):
        for k in range(n_shares):
            beyond = errors[0, i] + share[k] * ground[0, i]
            far = beyond * one_over_above[k]
            near = errors[1, i] + share[k] * ground[1, i] - beyond * beside[k]
            near *= one_over[k]
            here = errors[2, i] + share[k] * ground[2, i]
            here -= near * near * pivot[k] + far * beyond
            rest = z[i] - near * white[k] - far * white_above[k]
            pivot[k], one_over_above[k], one_over[k] = here, one_over[k], 1.0 / here
            white_above[k], white[k], beside[k] = white[k], rest, near
            square[k] += rest * rest * one_over[k]
            product[k] *= here
            least[k] = min(least[k], here)
        if i % ROWS_A_LOG == ROWS_A_LOG - 1 or i == len(z) - 1:
            for k in range(n_shares):
                log[k] += np.log(abs(product[k]))
                product[k] = 1.0
    for k in range(n_shares):
        if not (least[k] > 0.0 and np.isfinite(log[k])):
            log[k], square[k] = np.inf, 0.0
    return carried[:2]


Source = Literal["given", "estimated", "assumed"]

FINEST_M = 0.1
"""An error that is not given is never taken as smaller: ground is grass and stones."""
FEWEST_POINTS = 15
"""Fewer points do not tell their error: it is taken as `FINEST_M`."""
DIFFERENCES = 4
"""Order of the differences that bound the error from above."""
VARIANCE_OF_DIFFERENCES = 5.26
"""n times the relative variance of the squared error by fourth differences: 2 Σ ρ²."""
N_WAVELENGTHS, N_INSIDE = 48, 16
"""Wavelengths tried, and then between the neighbours of the best: three passes, and one."""


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
    if sigma is not None or len(x) < FEWEST_POINTS:
        source: Source = "assumed" if sigma is None else "given"
        sigma = np.full(len(x), FINEST_M) if sigma is None else sigma
        penalty = 1.0 if len(x) < 3 else Smoothing(x, y, sigma).best(1.0)[0]
        return PointError(sigma, source, penalty)
    smoothing = Smoothing(x, y, np.ones(len(x)))
    penalty, error = smoothing.best()
    differences, relative = difference_error(x, y)
    known = differences if differences < (1.0 - 2.0 * relative) * error else error
    known = max(known, FINEST_M)
    if known != error:
        penalty, _ = smoothing.best(known)
    return PointError(np.full(len(x), known), "estimated", penalty)


def difference_error(x: Floats, y: Floats) -> tuple[float, float]:
    """The error (m) by fourth divided differences, and its relative standard error."""
    n = DIFFERENCES + 1
    place, height = sliding_window_view(x, n), sliding_window_view(y, n)
    # Scaled by the width of each window, so that no product runs out of range.
    apart = (place[:, :, None] - place[:, None]) / (place[:, -1:, None] - place[:, :1, None])
    weight = 1.0 / np.prod(apart + np.eye(n), axis=2)
    squares = np.sum(weight * height, axis=1) ** 2 / np.sum(weight**2, axis=1)
    relative = 0.5 * np.sqrt(VARIANCE_OF_DIFFERENCES / len(squares))
    return float(np.sqrt(np.mean(squares))), float(relative)


class Smoothing:
    """How likely penalties are, by the restricted likelihood of points with errors `sigma` (m).

    Sought over the wavelength that evenly spaced points would keep half of: from half their
    spacing, where the spline goes through the points, to four times the path, a straight line.
    """

    def __init__(self, x: Floats, y: Floats, sigma: Floats) -> None:
        self._contrasts = _contrasts(x, y, sigma)
        length = float(x[-1] - x[0])
        self._density = float(np.sum(1.0 / sigma**2)) / length
        self._tiny = 1e-18 * float(np.ptp(y)) ** 2 + 1e-18
        ends = np.log(0.5 * length / (len(x) - 1)), np.log(4.0 * length)
        self._grid = np.linspace(*ends, N_WAVELENGTHS)
        self._on_grid = self._forms(self._grid)

    def best(self, times: float | None = None) -> tuple[float, float]:
        """The penalty of the largest likelihood, and what all errors are to be multiplied with.

        That is `times`, or what the likelihood says where it is None.
        """
        k = int(np.argmin(self._costs(self._on_grid, times)))
        ends = self._grid[max(k - 1, 0)], self._grid[min(k + 1, N_WAVELENGTHS - 1)]
        inside = np.linspace(*ends, N_INSIDE)
        least = lowest(inside, self._costs(self._forms(inside), times))
        if times is None:
            times = float(np.sqrt(self._variance(self._forms(np.array([least]))[1, 0])))
        # The penalty of errors as they were, beside Σ ((y - f) / σ)²; of larger ones it is less.
        return self._penalty(least) / times**2, times

    def _penalty(self, log_wavelength: Floats | float) -> Any:
        return self._density * (np.exp(log_wavelength) / (2.0 * np.pi)) ** 4

    def _forms(self, log_wavelength: Floats) -> Floats:
        return np.asarray(band_forms(*self._contrasts, 1.0 / self._penalty(log_wavelength)))

    def _variance(self, square: Any) -> Any:
        return square / len(self._contrasts[2]) + self._tiny

    def _costs(self, forms: Floats, times: float | None) -> Floats:
        """Minus the log likelihoods up to a constant, by `band_forms` `[2, n]`."""
        determinant, square = forms
        if times is None:
            n = len(self._contrasts[2])
            return 0.5 * (determinant + n * np.log(self._variance(square)))
        return 0.5 * (determinant + square / times**2)


def lowest(x: Floats, cost: Floats) -> float:
    """Where costs `[n]` at even steps of x `[n]` are least: the vertex through the least three."""
    k = int(np.argmin(cost))
    if not 0 < k < len(x) - 1:
        return float(x[k])
    before, here, after = cost[k - 1 : k + 2]
    bend = before - 2.0 * here + after
    share = 0.5 * (before - after) / bend if 0.0 < bend < np.inf else 0.0
    return float(x[k] + share * (x[k + 1] - x[k]))


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
