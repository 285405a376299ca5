"""Regularisation of the raw points of a path, and the error of these (docs/theory/motion.md).

Ground is a cubic spline with evenly spaced knots, much closer than the block is long, so that they
lose nothing; all matrices are bands of seven, and a path costs milliseconds however many points it
has. How far points want smoothing is the penalty λ = 1/τ² of the spline. Second divided differences
of the points know nothing of level and slope: their likelihood is the restricted one (REML), with
a band of five as covariance.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import legder, legval, legvander
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded

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


BLOCK_M = 100.0
"""Length of the block, the wavelength of which it feels half."""
BLOCK_SHARE = 0.1
"""On a path shorter than 1 km the block is this share of it."""
KNOTS_A_BLOCK = 5

# Cubic B-splines over one interval u in [0, 1]: rows are the four, columns powers of u.
PIECES = np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]]) / 6.0


@dataclass(frozen=True, slots=True, eq=False)
class GroundPosterior:
    """What points tell of the ground: a normal distribution of the spline's coefficients.

    `mean` `[n]`; `factor` `[4, n]` is the banded Cholesky factor of its precision. `felt` and
    `gram` `[4, n]` make the ground that the block feels: the curve f that makes
    ∫ (f - g)² + (L/2π)⁴ ∫ f''² least, which keeps 1 / (1 + (L/Λ)⁴) of a wavelength Λ.
    """

    knots: Floats
    mean: Floats
    factor: Floats
    felt: Floats
    gram: Floats

    def ground(self) -> BSpline:
        """The most likely ground, as the block feels it."""
        smooth = cho_solve_banded((self.felt, False), _times(self.gram, self.mean))
        return BSpline(self.knots, smooth, 3)

    def sd(self, x: Floats) -> Floats:
        """Standard deviation (m) of the elevation at x `[n_x]` of the ground that is felt."""
        rows = BSpline.design_matrix(x, self.knots, 3, extrapolate=True).toarray().T
        rows = _times(self.gram, cho_solve_banded((self.felt, False), rows))
        # Uᵀ z = rows, and the variance is |z|².
        lower = np.zeros_like(self.factor)
        for k in range(4):
            lower[k, : len(self.mean) - k] = self.factor[3 - k, k:]
        return np.asarray(np.sqrt(np.sum(solve_banded((3, 0), lower, rows) ** 2, axis=0)))


def block_length(length: float) -> float:
    """Length (m) of the block on a path of this length (m)."""
    return min(BLOCK_M, BLOCK_SHARE * length)


def ground_posterior(
    x: Floats, y: Floats, sigma: Floats, penalty: float, block_m: float
) -> GroundPosterior:
    """Fit points with errors `sigma` `[n_points]`: Σ ((y - f) / σ)² + `penalty` ∫ f''²."""
    n = max(4, ceil(KNOTS_A_BLOCK * (x[-1] - x[0]) / block_m))
    step = float(x[-1] - x[0]) / n
    normal, right = _normal_equations(x, y, sigma, step, n)
    # ∫ u^i u^j du, and the same of second derivatives.
    k = np.arange(4)
    squares = 1.0 / (k[:, None] + k + 1.0)
    bent = PIECES[:, 2:] * [2.0, 6.0]
    gram = _assembled(step * PIECES @ squares @ PIECES.T, n)
    bending = _assembled(step**-3 * bent @ squares[:2, :2] @ bent.T, n)
    factor = cholesky_banded(normal + penalty * bending)
    return GroundPosterior(
        knots=x[0] + step * np.arange(-3, n + 4),
        mean=cho_solve_banded((factor, False), right),
        factor=factor,
        felt=cholesky_banded(gram + (block_m / (2.0 * np.pi)) ** 4 * bending),
        gram=gram,
    )


@kernel
def _normal_equations(x: Floats, y: Floats, sigma: Floats, step: float, n: int):  # type: ignore[no-untyped-def]
    """Upper bands `[4, n + 3]` and right side `[n + 3]` of least squares weighted by 1/σ²."""
    normal, right = np.zeros((4, n + 3)), np.zeros(n + 3)
    value = np.empty(4)
    for k in range(len(x)):
        place = (x[k] - x[0]) / step
        interval = min(int(place), n - 1)
        u = place - interval
        for i in range(4):
            a = PIECES[i]
            value[i] = (a[0] + u * (a[1] + u * (a[2] + u * a[3]))) / sigma[k]
        for i in range(4):
            right[interval + i] += value[i] * y[k] / sigma[k]
            for j in range(i, 4):
                normal[3 - (j - i), interval + j] += value[i] * value[j]
    return normal, right


def _assembled(element: Floats, n: int) -> Floats:
    """Upper bands `[4, n + 3]` of the sum of one element's matrix `[4, 4]` over n intervals."""
    bands = np.zeros((4, n + 3))
    for i in range(4):
        for j in range(i, 4):
            bands[3 - (j - i), j : j + n] += element[i, j]
    return bands


def _times(bands: Floats, vector: Floats) -> Floats:
    """The symmetric matrix of these upper bands times a vector or columns `[n, …]`."""
    column = (slice(None),) + (None,) * (vector.ndim - 1)
    result = bands[3][column] * vector
    for k in range(1, 4):
        band = bands[3 - k, k:][column]
        result[:-k] += band * vector[k:]
        result[k:] += band * vector[:-k]
    return np.asarray(result)


DEGREE = 8
PENALTY = 1e-4
N_SAMPLED = 4001
KEPT = 32
"""Paths, those asked last, of which it is kept what can be made again from their ground."""
POINTS_A_TERM = 2
"""With fewer points for each of its terms a polynomial cannot show that it misses them."""


class GroundPoints(NamedTuple):
    """Points (x, y) with errors `sigma` `[n_points]` (m), as `ground_posterior` takes them."""

    x: Floats
    y: Floats
    sigma: Floats
    penalty: float
    block_m: float


@dataclass(frozen=True, slots=True, eq=False)
class SmoothProfile:
    """A path y = f(x) with two continuous derivatives; x in metres, downhill to the right.

    `knots` are the places where its higher derivatives jump. `rms_m` is the misfit, `sigma_m` the
    error of the points that it should equal, both as root mean squares weighted by 1/σ²;
    `sigma_source` says whence that error is. `points` are those that it was made of. A polynomial
    that was asked for by itself has none of these three.
    """

    method: Literal["legendre", "spline"]
    max_deviation_m: float
    x_min: float
    x_max: float
    knots: Floats
    curve: BSpline | Legendre
    degree: int | None = None
    smoothing: float | None = None
    rms_m: float = 0.0
    sigma_m: float = 0.0
    sigma_source: Source | None = None
    points: GroundPoints | None = None

    @property
    @lru_cache(maxsize=KEPT)  # noqa: B019 (here and below: those asked for last are kept)
    def posterior(self) -> GroundPosterior | None:
        """What the points tell of the ground: ten times as large as the path, so kept a while."""
        return None if self.points is None else ground_posterior(*self.points)

    @lru_cache(maxsize=KEPT)  # noqa: B019
    def sampled(self) -> tuple[Floats, Floats]:
        """Places x, and elevations there, evenly along the path, `[N_SAMPLED]`; kept a while."""
        x = np.linspace(self.x_min, self.x_max, N_SAMPLED)
        return x, self.height(x)

    def height(self, x: Floats | float) -> Floats:
        """Elevation at x."""
        return np.asarray(self.curve(np.asarray(x, dtype=float)))

    def derivatives(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """(f, f', f'') at x, with its shape."""
        slope, bending = self._differentiated()
        return self.curve(x), slope(x), bending(x)

    @lru_cache(maxsize=KEPT)  # noqa: B019
    def _differentiated(self) -> tuple[Any, Any]:
        f = self.curve
        of_order = f.deriv if isinstance(f, Legendre) else f.derivative
        return of_order(1), of_order(2)


def smooth_profile(x: Floats, y: Floats, sigma: Floats | None = None) -> SmoothProfile:
    """Regularise the points (x, y), both `[n_points]`, x strictly rising.

    `sigma` `[n_points]` (m) is the error of the elevations, estimated where it is not given. By the
    Legendre polynomial where its misfit is within that error, root mean square against root mean
    square; else by the smoothing spline.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    error = point_error(x, y, sigma)
    spline = spline_profile(x, y, error, block_length(float(x[-1] - x[0])))
    if len(x) < POINTS_A_TERM * (DEGREE + 1):
        return spline
    polynomial = legendre_profile(x, y)
    deviation = polynomial.height(x) - y
    if not np.mean((deviation / error.sigma) ** 2) <= 1.0:
        return spline
    return replace(
        polynomial,
        rms_m=_weighted_rms(deviation, error.sigma),
        sigma_m=spline.sigma_m,
        sigma_source=spline.sigma_source,
        points=spline.points,
    )


def legendre_profile(
    x: Floats, y: Floats, degree: int = DEGREE, penalty: float = PENALTY
) -> SmoothProfile:
    """Normalised Legendre polynomials in r ∈ [-1, 1], minimising Σ (y_i - f_i)² + λ Σ f''(r_i)²."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    degree = min(degree, len(x) - 1)
    r = 2.0 * (x - x[0]) / (x[-1] - x[0]) - 1.0
    norms = np.sqrt(np.arange(degree + 1) + 0.5)
    design = legvander(r, degree) * norms
    bending = np.sqrt(penalty) * legval(r, legder(np.diag(norms), 2)).T
    coefficients = np.linalg.lstsq(
        np.vstack([design, bending]), np.concatenate([y, np.zeros(len(x))]), rcond=None
    )[0]
    f = Legendre(coefficients * norms, domain=[x[0], x[-1]])
    rms_m = float(np.sqrt(np.mean((f(x) - y) ** 2)))
    knots = np.empty(0)
    return _profile(f, x, y, method="legendre", degree=degree, knots=knots, rms_m=rms_m)


def _profile(f: BSpline | Legendre, x: Floats, y: Floats, **other: Any) -> SmoothProfile:
    """The path along the curve f through the points, with these further fields."""
    return SmoothProfile(
        max_deviation_m=float(np.max(np.abs(f(x) - y))),
        x_min=float(x[0]),
        x_max=float(x[-1]),
        curve=f,
        **other,
    )


def spline_profile(x: Floats, y: Floats, error: PointError, block_m: float) -> SmoothProfile:
    """The smoothing spline of points with these errors, as a block of `block_m` (m) feels it."""
    points = GroundPoints(x, y, error.sigma, error.penalty, block_m)
    f = ground_posterior(*points).ground()
    return _profile(
        f,
        x,
        y,
        method="spline",
        smoothing=error.penalty,
        knots=np.asarray(f.t[4:-4]),
        rms_m=_weighted_rms(f(x) - y, error.sigma),
        sigma_m=_weighted_rms(error.sigma, error.sigma),
        sigma_source=error.source,
        points=points,
    )


def _weighted_rms(deviation: Floats, sigma: Floats) -> float:
    """Root of the mean of squares `[n_points]`, weighted by 1/σ²."""
    return float(np.sqrt(np.average(deviation**2, weights=sigma**-2)))
