"""What measured speeds say about friction between the frictions of the tables.

Speeds tell friction more closely than the tables are spaced. Between two frictions u² is nearly
linear in μ (exactly so where nothing but the drive depends on it), unlike u near the stop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SPLIT = 16
"""Parts of each cell of the friction grid."""
DEPTH = 40.0
"""Frictions whose log likelihood is that much below the best are left out."""
SPEED_CORRELATION_M = 100.0
"""Length over which the model's error of speed stays alike: about that of a terrain step."""


class Track(NamedTuple):
    """One event at fine frictions: `grid`, `record`, `left`, `speeds` `[n_fine(, n_speeds)]`."""

    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    speeds: Floats


def squares(speeds: Floats) -> Floats:
    """u² `[n_friction, n_places]`, carried on straight, below 0, to the first friction that stops
    the block short of a place, so that the stop has its place between this and the one before."""
    square = speeds**2
    stops = np.flatnonzero(np.diff(speeds == 0.0, axis=0).any(axis=1)) + 1
    for c in stops[stops > 1]:
        short = (speeds[c] == 0.0) & (speeds[c - 1] > 0.0)
        ahead = 2.0 * square[c - 1] - square[c - 2]
        square[c] = np.where(short, np.minimum(ahead, 0.0), square[c])
    return np.asarray(square)


@njit(cache=True, nogil=True)
def between(mu, record, left, speeds, log_likelihood, observed_left):  # type: ignore[no-untyped-def]
    """Tables of one event `[n_friction(, n_speeds)]` over finer frictions about the likely ones.

    `log_likelihood` `[n_friction - 1]` bounds what each cell of the grid `mu` can hold. Where the
    block stops short of a place in the next friction, its u² is carried on from the cell before.
    """
    good = np.flatnonzero(log_likelihood > np.max(log_likelihood) - DEPTH)
    first, last = max(good[0] - 1, 0), min(good[-1] + 2, len(mu) - 1)
    n, n_places = SPLIT * (last - first) + 1, speeds.shape[1]
    grid, fine_record = np.empty(n), np.empty(n)
    fine_left, fine_speeds = np.empty(n, dtype=np.bool_), np.empty((n, n_places))
    rise = np.empty(n_places)
    for j in range(first, last):
        for a in range(n_places):
            low, high = speeds[j, a] ** 2, speeds[j + 1, a] ** 2
            rise[a] = high - low
            if high == 0.0 and low > 0.0 and j > 0:
                rise[a] = low - speeds[j - 1, a] ** 2
        for k in range(SPLIT):
            share, row = k / SPLIT, SPLIT * (j - first) + k
            grid[row] = mu[j] + share * (mu[j + 1] - mu[j])
            fine_record[row] = record[j] + share * (record[j + 1] - record[j])
            # The status changes midway for those who left; others may have stopped up to the last.
            fine_left[row] = left[j] and left[j + 1]
            if k == 0:
                fine_left[row] = left[j]
            elif observed_left:
                fine_left[row] = left[j] if share < 0.5 else left[j + 1]
            for a in range(n_places):
                fine_speeds[row, a] = np.sqrt(max(speeds[j, a] ** 2 + share * rise[a], 0.0))
    grid[n - 1], fine_record[n - 1], fine_left[n - 1] = mu[last], record[last], left[last]
    fine_speeds[n - 1] = speeds[last]
    return Track(grid, fine_record, fine_left, fine_speeds)


@njit(cache=True, nogil=True)
def speed_log_likelihood(x, speed, sigma, predicted, scatter):  # type: ignore[no-untyped-def]
    """Log density of the speeds of one track given each friction, `[n_friction]`.

    Errors are those of the measurement at the places `x` (m), independent with `sigma`
    `[n_speeds]`, plus the model's, with standard deviation `scatter` and correlation
    exp(-|Δx| / SPEED_CORRELATION_M). `predicted` `[n_friction, n_speeds]`, all in m/s.
    """
    k = len(x)
    covariance = np.empty((k, k))
    for a in range(k):
        for b in range(k):
            alike = np.exp(-abs(x[a] - x[b]) / SPEED_CORRELATION_M)
            covariance[a, b] = scatter * scatter * alike
        covariance[a, a] += sigma[a] ** 2
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    constant = 0.5 * k * np.log(2.0 * np.pi)
    for a in range(k):
        constant -= np.log(whiten[a, a])
    result = np.empty(len(predicted))
    misfit = np.empty(k)
    for j in range(len(predicted)):
        total = 0.0
        for a in range(k):
            misfit[a] = speed[a] - predicted[j, a]
            z = 0.0
            for b in range(a + 1):
                z += whiten[a, b] * misfit[b]
            total += z * z
        result[j] = -0.5 * total - constant
    return result
