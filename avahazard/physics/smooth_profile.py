"""Regularisation of the raw points of a path (docs/theory/motion.md).

Ground is a cubic spline with evenly spaced knots, much closer than the block is long, so that they
lose nothing; all matrices are bands of seven, and a path costs milliseconds however many points it
has.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import legder, legval, legvander
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.point_error import PointError, Source, point_error

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
