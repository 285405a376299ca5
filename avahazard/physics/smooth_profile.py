"""Regularisation of the raw points of a path (docs/theory/motion.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import legder, legval, legvander
from scipy.interpolate import BSpline

from avahazard.arrays import Floats
from avahazard.physics.ground_spline import GroundPosterior, block_length, ground_posterior
from avahazard.physics.point_error import PointError, Source, point_error

MOST_CONDITION = 1e8
"""Condition of the normal equations up to which squares of the misfit keep six digits."""


def least_misfit(x: Floats, y: Floats, sigma: Floats, degree: int) -> float:
    """Mean of ((y - f) / σ)² of the polynomial f for which it is least, all `[n_points]`.

    No other polynomial of this degree has less, whatever it was fitted by. Found by the normal
    equations, a fifth of the time of a fit that needs all digits; 0 where they cannot tell.
    """
    r = 2.0 * (x - x[0]) / (x[-1] - x[0]) - 1.0
    design = legvander(r, degree) / sigma[:, None]
    scaled = y / sigma
    values, vectors = np.linalg.eigh(design.T @ design)
    if not values[0] * MOST_CONDITION >= values[-1]:
        return 0.0
    coefficients = vectors @ ((vectors.T @ (design.T @ scaled)) / values)
    return float(np.mean((scaled - design @ coefficients) ** 2))


Method = Literal["auto", "legendre", "spline"]

DEGREE = 8
PENALTY = 1e-4
N_SAMPLED = 4001
KEPT = 32
"""Paths, those asked last, of which it is kept what can be made again from their ground."""
POINTS_A_TERM = 2
"""With fewer points for each of its terms a polynomial cannot show that it misses them."""
SLACK = 1e-3
"""By so much the least misfit, in squares, may be in error."""


class GroundPoints(NamedTuple):
    """Points (x, y) with errors `sigma`, all `[n_points]` (m), and how stiff ground is in them.

    `penalty` and `block_m` are those of `ground_posterior`.
    """

    x: Floats
    y: Floats
    sigma: Floats
    penalty: float
    block_m: float


@dataclass(frozen=True, slots=True, eq=False)
class SmoothProfile:
    """A path y = f(x) with two continuous derivatives; x in metres, downhill to the right.

    `derivatives(x)` returns (f, f', f'') with the shape of `x`; `knots` are the places where
    higher derivatives jump. `rms_m` is the misfit, `sigma_m` the error of the points that it should
    equal, both as root mean squares weighted by 1/σ²; `sigma_source` says whence that error is.
    `points` are those that it was made of. A polynomial that was asked for by itself
    has none of these three.
    """

    method: Literal["legendre", "spline"]
    degree: int | None
    smoothing: float | None
    max_deviation_m: float
    x_min: float
    x_max: float
    knots: Floats
    derivatives: Callable[[Floats], tuple[Floats, Floats, Floats]]
    rms_m: float = 0.0
    sigma_m: float = 0.0
    sigma_source: Source | None = None
    points: GroundPoints | None = None

    @property
    def posterior(self) -> GroundPosterior | None:
        """What the points tell of the ground: ten times as large as the path, so kept a while."""
        return None if self.points is None else _posterior(self)

    def sampled(self) -> tuple[Floats, Floats]:
        """Places x, and elevations there, evenly along the path, `[N_SAMPLED]`; kept a while."""
        return _sampled(self)

    def height(self, x: Floats | float) -> Floats:
        """Elevation at x."""
        place = np.asarray(x, dtype=float)
        if isinstance(self.derivatives, Derivatives):
            return self.derivatives.curve(place)
        return self.derivatives(place)[0]


@lru_cache(maxsize=KEPT)
def _sampled(smooth: SmoothProfile) -> tuple[Floats, Floats]:
    x = np.linspace(smooth.x_min, smooth.x_max, N_SAMPLED)
    return x, smooth.height(x)


@lru_cache(maxsize=KEPT)
def _posterior(smooth: SmoothProfile) -> GroundPosterior:
    assert smooth.points is not None
    return ground_posterior(*smooth.points)


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """A curve with its first two derivatives, as `SmoothProfile.derivatives` gives them.

    Unlike a function that is made where it is needed, it can be sent to another process.
    """

    curve: BSpline | Legendre

    def __call__(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """(f, f', f'') at x."""
        slope, bending = _differentiated(self)
        return self.curve(x), slope(x), bending(x)


@lru_cache(maxsize=KEPT)
def _differentiated(of: Derivatives) -> tuple[Any, Any]:
    f = of.curve
    if isinstance(f, Legendre):
        return f.deriv(1), f.deriv(2)
    return f.derivative(1), f.derivative(2)


def smooth_profile(
    x: Floats, y: Floats, sigma: Floats | None = None, method: Method = "auto"
) -> SmoothProfile:
    """Regularise the points (x, y), both `[n_points]`, x strictly rising.

    `sigma` `[n_points]` (m) is the error of the elevations, estimated where it is not given.
    `auto` takes the Legendre polynomial where its misfit is within that error, root mean square
    against root mean square; else the smoothing spline.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    error = point_error(x, y, sigma)
    spline = _spline(x, y, error, block_length(float(x[-1] - x[0])))
    if method == "spline" or (method == "auto" and not _may_be_polynomial(x, y, error.sigma)):
        return spline
    polynomial = legendre_profile(x, y)
    deviation = polynomial.height(x) - y
    within = float(np.mean((deviation / error.sigma) ** 2)) <= 1.0
    if method == "auto" and not within:
        return spline
    return replace(
        polynomial,
        rms_m=_weighted_rms(deviation, error.sigma),
        sigma_m=spline.sigma_m,
        sigma_source=spline.sigma_source,
        points=spline.points,
    )


def _may_be_polynomial(x: Floats, y: Floats, sigma: Floats) -> bool:
    """Whether a polynomial may be within the error: on most paths none is, and it is not made."""
    enough = len(x) >= POINTS_A_TERM * (DEGREE + 1)
    return enough and least_misfit(x, y, sigma, DEGREE) <= 1.0 + SLACK


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
    deviation = f(x) - y
    return SmoothProfile(
        method="legendre",
        degree=degree,
        smoothing=None,
        max_deviation_m=float(np.max(np.abs(deviation))),
        x_min=float(x[0]),
        x_max=float(x[-1]),
        knots=np.empty(0),
        derivatives=Derivatives(f),
        rms_m=float(np.sqrt(np.mean(deviation**2))),
    )


def spline_profile(
    x: Floats, y: Floats, sigma: Floats | float | None = None, block_m: float | None = None
) -> SmoothProfile:
    """The smoothing spline of points with errors `sigma` (m), as a block of `block_m` feels it."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    given = None if sigma is None else np.broadcast_to(np.asarray(sigma, dtype=float), x.shape)
    length = block_length(float(x[-1] - x[0])) if block_m is None else block_m
    return _spline(x, y, point_error(x, y, given), length)


def _spline(x: Floats, y: Floats, error: PointError, block_m: float) -> SmoothProfile:
    points = GroundPoints(x, y, error.sigma, error.penalty, block_m)
    f = ground_posterior(*points).ground()
    deviation = f(x) - y
    return SmoothProfile(
        method="spline",
        degree=None,
        smoothing=error.penalty,
        max_deviation_m=float(np.max(np.abs(deviation))),
        x_min=float(x[0]),
        x_max=float(x[-1]),
        knots=_inner_knots(f),
        derivatives=Derivatives(f),
        rms_m=_weighted_rms(deviation, error.sigma),
        sigma_m=_weighted_rms(error.sigma, error.sigma),
        sigma_source=error.source,
        points=points,
    )


def _inner_knots(f: BSpline) -> Floats:
    return np.asarray(f.t[4:-4])


def _weighted_rms(deviation: Floats, sigma: Floats) -> float:
    """Root of the mean of squares `[n_points]`, weighted by 1/σ²."""
    return float(np.sqrt(np.average(deviation**2, weights=sigma**-2)))
