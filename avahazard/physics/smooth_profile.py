"""Regularisation of the raw points of a path (docs/theory/motion.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import Legendre
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Method = Literal["auto", "legendre", "spline"]

DEGREE = 8
PENALTY = 1e-4
MISFIT_LIMIT_M = 10.0
"""Largest deviation of the polynomial from the points that is still accepted."""
SPLINE_DEVIATION_M = 5.0
"""Largest deviation that the smoothing spline is stiffened to."""
FEWEST_SPLINE_POINTS = 5
"""Paths with fewer points are first filled up on the straight lines between them."""


@dataclass(frozen=True, slots=True, eq=False)
class SmoothProfile:
    """A path y = f(x) with two continuous derivatives; x in metres, downhill to the right.

    `derivatives(x)` returns (f, f', f'') with the shape of `x`; `knots` are the places where
    higher derivatives jump.
    """

    method: Literal["legendre", "spline"]
    degree: int | None
    smoothing: float | None
    max_deviation_m: float
    x_min: float
    x_max: float
    knots: Floats
    derivatives: Callable[[Floats], tuple[Floats, Floats, Floats]]

    def height(self, x: Floats | float) -> Floats:
        """Elevation at x."""
        return self.derivatives(np.asarray(x, dtype=float))[0]


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """A curve with its first two derivatives, as `SmoothProfile.derivatives` gives them.

    Unlike a function that is made where it is needed, it can be sent to another process.
    """

    curve: Callable[[Floats], Floats]
    slope: Callable[[Floats], Floats]
    bending: Callable[[Floats], Floats]

    def __call__(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """(f, f', f'') at x."""
        return self.curve(x), self.slope(x), self.bending(x)


def smooth_profile(x: Floats, y: Floats, method: Method = "auto") -> SmoothProfile:
    """Regularise the points (x, y), both `[n_points]`, x strictly rising.

    `auto` takes the Legendre polynomial unless it misses a point by more than
    `MISFIT_LIMIT_M`; then the smoothing spline.
    """
    if method != "spline":
        fitted = legendre_profile(x, y)
        if method == "legendre" or fitted.max_deviation_m <= MISFIT_LIMIT_M:
            return fitted
    return spline_profile(x, y)


def legendre_profile(
    x: Floats, y: Floats, degree: int = DEGREE, penalty: float = PENALTY
) -> SmoothProfile:
    """Normalised Legendre polynomials in r ∈ [-1, 1], minimising Σ (y_i - f_i)² + λ Σ f''(r_i)²."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    degree = min(degree, len(x) - 1)
    r = 2.0 * (x - x[0]) / (x[-1] - x[0]) - 1.0
    basis = [Legendre.basis(n) * np.sqrt(n + 0.5) for n in range(degree + 1)]
    design = np.column_stack([p(r) for p in basis])
    bending = np.sqrt(penalty) * np.column_stack([p.deriv(2)(r) for p in basis])
    coefficients = np.linalg.lstsq(
        np.vstack([design, bending]), np.concatenate([y, np.zeros(len(x))]), rcond=None
    )[0]
    norms = np.sqrt(np.arange(degree + 1) + 0.5)
    f = Legendre(coefficients * norms, domain=[x[0], x[-1]])
    slope, bend = f.deriv(1), f.deriv(2)
    return SmoothProfile(
        method="legendre",
        degree=degree,
        smoothing=None,
        max_deviation_m=float(np.max(np.abs(f(x) - y))),
        x_min=float(x[0]),
        x_max=float(x[-1]),
        knots=np.empty(0),
        derivatives=Derivatives(f, slope, bend),
    )


def spline_profile(x: Floats, y: Floats, deviation: float = SPLINE_DEVIATION_M) -> SmoothProfile:
    """The stiffest cubic smoothing spline that stays within `deviation` metres of every point."""
    from scipy.interpolate import make_smoothing_spline  # noqa: PLC0415 (import cost)

    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    while len(x) < FEWEST_SPLINE_POINTS:
        middles = 0.5 * (x[1:] + x[:-1])
        filled = np.sort(np.concatenate([x, middles]))
        x, y = filled, np.interp(filled, x, y)
    # The penalty is ∫ f''² dx: scaled by the mean spacing and length, its exponent has a
    # sensible range for any path.
    scale = (x[-1] - x[0]) ** 3

    def spline_of(log_smoothing: float):  # type: ignore[no-untyped-def]
        return make_smoothing_spline(x, y, lam=scale * 10.0**log_smoothing)

    low, high = -14.0, 2.0
    for _ in range(24):
        middle = 0.5 * (low + high)
        if np.max(np.abs(spline_of(middle)(x) - y)) <= deviation:
            low = middle
        else:
            high = middle
    f = spline_of(low)
    slope, bend = f.derivative(1), f.derivative(2)
    return SmoothProfile(
        method="spline",
        degree=None,
        smoothing=float(scale * 10.0**low),
        max_deviation_m=float(np.max(np.abs(f(x) - y))),
        x_min=float(x[0]),
        x_max=float(x[-1]),
        knots=x[1:-1].copy(),
        derivatives=Derivatives(f, slope, bend),
    )
