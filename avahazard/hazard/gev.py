"""The generalised extreme value distribution.

The sign of the shape is that of `scipy.stats.genextreme`: positive has an upper bound, negative a
heavy tail.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from avahazard.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Gev:
    """Shape, location and scale of many distributions at once, arrays `[n]`."""

    shape: Floats
    location: Floats
    scale: Floats

    def quantile(self, probability: float | Floats) -> Floats:
        """Value `[n]` that a maximum stays under with the given probability (-inf at 0)."""
        return np.asarray(
            stats.genextreme.ppf(probability, self.shape, loc=self.location, scale=self.scale)
        )

    def exceedance(self, values: Floats) -> Floats:
        """Chance `[n, n_values]` that a maximum is over each of `values`."""
        return np.asarray(
            stats.genextreme.sf(
                values[None, :],
                self.shape[:, None],
                loc=self.location[:, None],
                scale=self.scale[:, None],
            )
        )
