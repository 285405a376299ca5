"""What each record says about friction in brief: mean, variance and mass of its bump.

The screening fits thousands of made worlds; there the bump p(record | μ) over ν = log μ is taken
as normal, which needs no nodes. The mass holds the Jacobian |dν/dF| without which a regression of
back-calculated friction finds effects in pure noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.physics.constants import KEEPS_NAN

Floats = NDArray[np.float64]

REACH = 6.0


class Bumps(NamedTuple):
    """Per event `[n_events]`: mean and variance in ν, and log mass."""

    mean: Floats
    variance: Floats
    log_mass: Floats


class SpeedGrid(NamedTuple):
    """Speeds predicted for the events that have measured ones, one set of tables.

    `row` `[n_events]` points to the event's row, -1 for none; `predicted`
    `[n_rows, n_coarse, n_places]` at every `stride`-th friction; `whiten`
    `[n_rows, n_places, n_places]` turns a misfit into independent unit errors (zero rows where
    an event has fewer places); `log_norm` `[n_rows]` is its log determinant term.
    """

    row: NDArray[np.int64]
    predicted: NDArray[np.float32]
    whiten: Floats
    log_norm: Floats
    stride: int


@njit(cache=True, fastmath=KEEPS_NAN, nogil=True)
def bumps(record, last_left, observed, sigma, left, log_mu, speed_grid, speeds):  # type: ignore[no-untyped-def]
    """Bumps of all events.

    `record` `[n_events, n_friction]` is what would be recorded, `last_left` `[n_events]` the
    last friction of the grid at which the block leaves (-1: none), `left` `[n_events]` the
    events that did leave (for these the speeds alone speak), `speeds` `[n_rows, n_places]`.
    """
    n, n_mu = record.shape
    mean = np.zeros(n)
    variance = np.zeros(n)
    log_mass = np.zeros(n)
    points = np.empty(4096)
    logs = np.empty(4096)
    for i in range(n):
        row = speed_grid.row[i]
        if left[i] and row < 0:
            continue
        count = 0
        nearest, gap = 0, np.inf
        for j in range(max(last_left[i], 0), n_mu - 1):
            if left[i]:
                break
            z0 = (record[i, j] - observed[i]) / sigma[i]
            z1 = (record[i, j + 1] - observed[i]) / sigma[i]
            if abs(z1) < gap:
                nearest, gap = j + 1, abs(z1)
            if min(z0, z1) > REACH or max(z0, z1) < -REACH:
                continue
            width = log_mu[j + 1] - log_mu[j]
            # Only the part of the cell within reach counts.
            t_low, t_high = 0.0, 1.0
            if z0 != z1:
                ta = (-REACH - z0) / (z1 - z0)
                tb = (REACH - z0) / (z1 - z0)
                t_low, t_high = max(0.0, min(ta, tb)), min(1.0, max(ta, tb))
            pieces = int(abs(z1 - z0) * (t_high - t_low)) + 1
            step = (t_high - t_low) / pieces
            for p in range(pieces):
                if count == len(points):
                    break
                t = t_low + (p + 0.5) * step
                z = z0 + t * (z1 - z0)
                points[count] = log_mu[j] + t * width
                logs[count] = -0.5 * z * z + np.log(step * width)
                if row >= 0:
                    logs[count] += _speed_log(speed_grid, row, j + t, speeds[row])
                count += 1
        if left[i]:
            for j in range(0, max(last_left[i], 1), 2):
                points[count] = log_mu[j]
                logs[count] = np.log(log_mu[j + 1] - log_mu[j]) + np.log(sigma[i]) + 0.919
                logs[count] += _speed_log(speed_grid, row, float(j), speeds[row])
                count += 1
        if count == 0:
            mean[i], variance[i] = log_mu[nearest], 1e-6
            log_mass[i] = -0.5 * min(gap, 100.0) ** 2 - np.log(sigma[i]) - 0.919 - 6.0
            continue
        top = -np.inf
        for c in range(count):
            top = max(top, logs[c])
        total, first, second = 0.0, 0.0, 0.0
        for c in range(count):
            a = np.exp(logs[c] - top)
            x = points[c] - points[0]
            total += a
            first += a * x
            second += a * x * x
        mean[i] = points[0] + first / total
        variance[i] = max(second / total - (first / total) ** 2, 1e-8)
        log_mass[i] = top + np.log(total) - np.log(sigma[i]) - 0.919
    return Bumps(mean, variance, log_mass)


@njit(cache=True, fastmath=KEEPS_NAN, nogil=True)
def _speed_log(grid, row, place, speeds):  # type: ignore[no-untyped-def]
    """Log density of one event's speeds at a place between points of the friction grid."""
    n_coarse, n_places = grid.predicted.shape[1], grid.predicted.shape[2]
    c = min(int(place / grid.stride), n_coarse - 2)
    t = min(place / grid.stride - c, 1.0)
    total = 0.0
    for a in range(n_places):
        value = 0.0
        for b in range(a + 1):
            if grid.whiten[row, a, b] != 0.0:
                u = (1.0 - t) * grid.predicted[row, c, b] + t * grid.predicted[row, c + 1, b]
                value += grid.whiten[row, a, b] * (speeds[b] - u)
        total += value * value
    return -0.5 * total - grid.log_norm[row]
