"""How near a polynomial can come to the points of a path."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import legvander

from avahazard.arrays import Floats

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
