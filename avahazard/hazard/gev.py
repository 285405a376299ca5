"""The generalised extreme value distribution.

The sign of the shape is that of `scipy.stats.genextreme`: positive has an upper bound, negative a
heavy tail.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import expm1, log1p

from avahazard.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Gev:
    """Shape, location and scale of many distributions at once, arrays `[n]`."""

    shape: Floats
    location: Floats
    scale: Floats

    def quantile(self, probability: float | Floats) -> Floats:
        """Value `[n]` that a maximum stays under with the given probability over 0."""
        reduced, shape = -np.log(-np.log(probability)), _nonzero(self.shape)
        return np.asarray(-expm1(-shape * reduced) / shape * self.scale + self.location)

    def exceedance(self, values: Floats) -> Floats:
        """Chance `[n, n_values]` that a maximum is over each of `values`."""
        shape = _nonzero(self.shape)[:, None]
        scaled = (values - self.location[:, None]) / self.scale[:, None]
        with np.errstate(divide="ignore", over="ignore"):
            # 1 is the bound: none is over it with a positive shape, all are with a negative one.
            reduced = -log1p(-np.minimum(shape * scaled, 1.0)) / shape
            return np.asarray(-expm1(-np.exp(-reduced)))


def _nonzero(shape: Floats) -> Floats:
    """The shape, next to nought where it is nought: so the formulas hold to the last digits."""
    return np.where(shape == 0.0, 1e-12, shape)
