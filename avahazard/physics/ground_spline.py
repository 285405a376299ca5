"""Ground as a cubic spline with evenly spaced knots: its fit, its error, and what a block feels.

The knots are much closer than the block is long, so that they lose nothing; all matrices are
bands of seven, and a path costs milliseconds however many points it has.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded

from avahazard.arrays import Floats
from avahazard.kernels import kernel

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
        return self._felt(self.mean)

    def sd(self, x: Floats) -> Floats:
        """Standard deviation (m) of the elevation at x `[n_x]` of the ground that is felt."""
        rows = BSpline.design_matrix(x, self.knots, 3, extrapolate=True).toarray().T
        rows = _times(self.gram, cho_solve_banded((self.felt, False), rows))
        # Uᵀ z = rows, and the variance is |z|².
        lower = np.zeros_like(self.factor)
        for k in range(4):
            lower[k, : len(self.mean) - k] = self.factor[3 - k, k:]
        return np.asarray(np.sqrt(np.sum(solve_banded((3, 0), lower, rows) ** 2, axis=0)))

    def _felt(self, coefficients: Floats) -> BSpline:
        smooth = cho_solve_banded((self.felt, False), _times(self.gram, coefficients))
        return BSpline(self.knots, smooth, 3)


def block_length(length: float) -> float:
    """Length (m) of the block on a path of this length (m)."""
    return min(BLOCK_M, BLOCK_SHARE * length)


def ground_posterior(
    x: Floats, y: Floats, sigma: Floats, penalty: float, block_m: float
) -> GroundPosterior:
    """Fit points (x, y) with errors `sigma`, all `[n_points]`: Σ ((y - f) / σ)² + λ ∫ f''².

    `block_m` is the length of the block, `penalty` is λ.
    """
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
