"""What measured speeds say about friction between the frictions of the tables.

Speeds tell friction more closely than the tables are spaced. Between two frictions u² is nearly
linear in μ (exactly so where nothing but the drive depends on it), unlike u near the stop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SPLIT = 16
"""Parts of each cell of the friction grid."""
DEPTH = 40.0
"""Frictions whose log likelihood is that much below the best are left out."""


class Track(NamedTuple):
    """One event at fine frictions: `grid`, `record`, `left`, `speeds` `[n_fine(, n_speeds)]`."""

    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    speeds: Floats


def between(
    mu: Floats,
    record: Floats,
    left: NDArray[np.bool_],
    speeds: Floats,
    log_likelihood: Floats,
    observed_left: bool,
) -> Track:
    """Tables of one event `[n_friction(, n_speeds)]` over finer frictions about the likely ones.

    `log_likelihood` `[n_friction - 1]` bounds what each cell of the grid `mu` can hold. Where the
    block stops short of a place in the next friction, its u² is carried on from the cell before.
    """
    good = np.flatnonzero(log_likelihood > np.max(log_likelihood) - DEPTH)
    first, last = max(int(good[0]) - 1, 0), min(int(good[-1]) + 2, len(mu) - 1)
    share = np.arange(SPLIT) / SPLIT

    def fine(a: Floats, rise: Floats) -> Floats:
        inside = a[first:last, None] + np.multiply.outer(share, rise[first:last]).swapaxes(0, 1)
        return np.concatenate([inside.reshape(-1, *a.shape[1:]), a[last : last + 1]])

    square = speeds**2
    rise = np.diff(square, axis=0)
    before = np.concatenate([rise[:1], rise[:-1]])
    rise = np.where((square[1:] == 0.0) & (square[:-1] > 0.0), before, rise)
    # The status changes midway for those who left; others may have stopped up to the last.
    inside = left[:-1] & left[1:]
    status = np.repeat(inside[:, None], SPLIT, axis=1)
    if observed_left:
        status = np.where(share < 0.5, left[:-1, None], left[1:, None])
    status[:, 0] = left[:-1]
    return Track(
        grid=fine(mu, np.diff(mu)),
        record=fine(record, np.diff(record)),
        left=np.append(status[first:last].ravel(), left[last]),
        speeds=np.sqrt(np.maximum(fine(square, rise), 0.0)),
    )
