"""Volumes that dwarf all others: slips of units more often than avalanches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FACTOR = 100.0
"""How many times the next smaller volume one must be to be suspect."""
MOST = 0.05
"""Where more than this share of the records lie beyond a gap, they are another kind of flow."""
FEWEST = 5


def dwarfing(log_volume: NDArray[np.float64]) -> NDArray[np.int64]:
    """Indices of the few volumes `[n]` (log m3, nan if unknown) beyond a gap, largest first."""
    known = np.flatnonzero(np.isfinite(log_volume))
    if len(known) < FEWEST:
        return np.zeros(0, dtype=np.int64)
    order = known[np.argsort(-log_volume[known], kind="stable")]
    most = max(1, int(MOST * len(order)))
    gaps = -np.diff(log_volume[order[: most + 1]])
    wide = np.flatnonzero(gaps > np.log(FACTOR))
    return order[: wide[-1] + 1] if len(wide) else order[:0]
