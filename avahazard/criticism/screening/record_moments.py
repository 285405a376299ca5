"""What each record says about friction in brief: mean, variance and mass of its likelihood.

The screening fits thousands of made worlds; there the likelihood p(record | μ) over ν = log μ is
taken as normal, which needs no nodes. The mass holds the Jacobian |dν/dF| without which a
regression of back-calculated friction finds effects in pure noise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.straight_density import straight_points
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

Floats = NDArray[np.float64]

REACH = 6.0
MOST_POINTS = 4096
SPEED_PIECES = 4
"""Parts of a cell of frictions where speeds tell them apart."""
DEPTH = 40.0
"""Frictions whose log density is that much below the best are left out."""


class RecordMoments(NamedTuple):
    """Per event `[n_events]`: mean and variance in ν, and log mass."""

    mean: Floats
    variance: Floats
    log_mass: Floats


class SpeedGrid(NamedTuple):
    """Speeds predicted for the events that have measured ones, one set of tables.

    `row` `[n_events]` points to the event's row, -1 for none; `square` `[n_rows, n_coarse,
    n_places]` is u² at every `stride`-th friction, below 0 where the block stops short; `whiten`
    `[n_rows, n_places, n_places]` turns a misfit into independent unit errors (zero rows where
    an event has fewer places); `log_norm` `[n_rows]` is its log determinant term.
    """

    row: NDArray[np.int64]
    square: NDArray[np.float32]
    whiten: Floats
    log_norm: Floats
    stride: int


STRETCH = 16
"""Cells of the grid of frictions whose records are looked at only if one can be near."""


def record_bounds(record: NDArray[np.float32]) -> NDArray[np.float32]:
    """Lowest and highest record of each stretch of frictions, `[n_events, n_stretches, 2]`."""
    starts = np.arange(0, max(record.shape[1] - 1, 1), STRETCH)
    low, high = np.minimum.reduceat(record, starts, 1), np.maximum.reduceat(record, starts, 1)
    # A cell reaches to the first point of the next stretch.
    after = record[:, np.minimum(starts + STRETCH, record.shape[1] - 1)]
    return np.stack([np.minimum(low, after), np.maximum(high, after)], axis=2)


@kernel
def record_moments(  # type: ignore[no-untyped-def]
    record, bounds, last_left, height, observed, sigma, left, log_mu, speed_grid, speeds
):
    """RecordMoments of all events.

    `record` `[n_events, n_friction]` is what would be recorded, `bounds` its `record_bounds`,
    `height` `[n_events]` the height of fall of events without a profile (else nan),
    `last_left` `[n_events]` the last friction of the grid at which the block leaves (-1: none),
    `left` `[n_events]` the events that did leave (for these the speeds alone speak), `speeds`
    `[n_rows, n_places]`.
    """
    n = len(record)
    mean = np.zeros(n)
    variance = np.zeros(n)
    log_mass = np.zeros(n)
    points = np.empty(MOST_POINTS)
    logs = np.empty(MOST_POINTS)
    misfit = np.empty(speed_grid.square.shape[2])
    for i in range(n):
        row = speed_grid.row[i]
        if left[i] and row < 0:
            continue
        if left[i]:
            count = _leaving_points(
                last_left[i], log_mu, speed_grid, row, speeds[row], misfit, points, logs
            )
            log_norm = 0.0
        elif not np.isnan(height[i]):
            count = straight_points(height[i], observed[i], sigma[i], True, points, logs)
            log_norm = 0.0
        elif row < 0:
            first = max(last_left[i], 0)
            found = _stop_moments(record[i], bounds[i], first, observed[i], sigma[i], log_mu)
            mean[i], variance[i], log_mass[i] = found
            continue
        else:
            count = _stop_points(
                record[i],
                bounds[i],
                max(last_left[i], 0),
                observed[i],
                sigma[i],
                log_mu,
                speed_grid,
                row,
                speeds[row],
                misfit,
                points,
                logs,
            )
            log_norm = -np.log(sigma[i]) - HALF_LOG_2PI
        if count == 0:
            mean[i], variance[i], log_mass[i] = _nearest(record[i], observed[i], sigma[i], log_mu)
            continue
        top = np.max(logs[:count])
        total, first, second = 0.0, 0.0, 0.0
        for c in range(count):
            a = np.exp(logs[c] - top)
            x = points[c] - points[0]
            total += a
            first += a * x
            second += a * x * x
        mean[i] = points[0] + first / total
        variance[i] = max(second / total - (first / total) ** 2, 1e-8)
        log_mass[i] = top + np.log(total) + log_norm
    return RecordMoments(mean, variance, log_mass)


@kernel
def _nearest(record, observed, sigma, log_mu):  # type: ignore[no-untyped-def]
    """Mean, variance and log mass where no friction of the table comes near the record."""
    z = (record - observed) / sigma
    nearest = np.argmin(np.abs(z))
    log_mass = -0.5 * min(abs(z[nearest]), 100.0) ** 2 - np.log(sigma) - HALF_LOG_2PI - 6.0
    return log_mu[nearest], 1e-6, log_mass


@kernel
def _stop_moments(record, bounds, first, observed, sigma, log_mu):  # type: ignore[no-untyped-def]
    """Mean, variance and log mass of the likelihood of a stop without speeds.

    The points are those of `_stop_points`, summed as they come: no record is so far from them that
    their masses had to be taken as logs.
    """
    total, by_place, by_square, origin = 0.0, 0.0, 0.0, np.nan
    scale = 1.0 / sigma
    for stretch in range(first // STRETCH, len(bounds)):
        if bounds[stretch, 0] - observed > REACH * sigma:
            continue
        if bounds[stretch, 1] - observed < -REACH * sigma:
            continue
        begin = max(stretch * STRETCH, first)
        z1 = (record[begin] - observed) * scale
        for j in range(begin, min((stretch + 1) * STRETCH, len(record) - 1)):
            z0 = z1
            z1 = (record[j + 1] - observed) * scale
            if (z0 > REACH and z1 > REACH) or (z0 < -REACH and z1 < -REACH):
                continue
            width = log_mu[j + 1] - log_mu[j]
            t_low, t_high = _within_reach(z0, z1)
            pieces = int(abs(z1 - z0) * (t_high - t_low)) + 1
            step = (t_high - t_low) / pieces
            if np.isnan(origin):
                origin = log_mu[j]
            for p in range(pieces):
                t = t_low + (p + 0.5) * step
                z = z0 + t * (z1 - z0)
                x = log_mu[j] + t * width - origin
                mass = step * width * np.exp(-0.5 * z * z)
                total += mass
                by_place += mass * x
                by_square += mass * x * x
    if total == 0.0:
        return _nearest(record, observed, sigma, log_mu)
    by_place /= total
    variance = max(by_square / total - by_place * by_place, 1e-8)
    return origin + by_place, variance, np.log(total) - np.log(sigma) - HALF_LOG_2PI


@kernel
def _within_reach(z0, z1):  # type: ignore[no-untyped-def]
    """The part of a cell, from z0 to z1 standard deviations, that is within reach."""
    if z0 == z1:
        return 0.0, 1.0
    ta = (-REACH - z0) / (z1 - z0)
    tb = (REACH - z0) / (z1 - z0)
    return max(0.0, min(ta, tb)), min(1.0, max(ta, tb))


@kernel
def _stop_points(  # type: ignore[no-untyped-def]
    record, bounds, first, observed, sigma, log_mu, speed_grid, row, speeds, misfit, points, logs
):
    """Points of the likelihood of a stop with speeds, and their log masses; returns how many."""
    count = 0
    best = -np.inf
    scale = 1.0 / sigma
    for stretch in range(first // STRETCH, len(bounds)):
        if bounds[stretch, 0] - observed > REACH * sigma:
            continue
        if bounds[stretch, 1] - observed < -REACH * sigma:
            continue
        begin = max(stretch * STRETCH, first)
        z1 = (record[begin] - observed) * scale
        for j in range(begin, min((stretch + 1) * STRETCH, len(record) - 1)):
            z0 = z1
            z1 = (record[j + 1] - observed) * scale
            if (z0 > REACH and z1 > REACH) or (z0 < -REACH and z1 < -REACH):
                continue
            width = log_mu[j + 1] - log_mu[j]
            # Only the part of the cell within reach counts.
            t_low, t_high = _within_reach(z0, z1)
            pieces = max(int(abs(z1 - z0) * (t_high - t_low)) + 1, SPEED_PIECES)
            step = (t_high - t_low) / pieces
            log_width = np.log(step * width)
            for p in range(pieces):
                if count == len(points):
                    return count
                t = t_low + (p + 0.5) * step
                z = z0 + t * (z1 - z0)
                points[count] = log_mu[j] + t * width
                logs[count] = log_width - 0.5 * z * z
                room = logs[count] - best + DEPTH
                logs[count] += _speed_log(speed_grid, row, speeds, j + t, misfit, room)
                if logs[count] < best - DEPTH:
                    continue
                best = max(best, logs[count])
                count += 1
    return count


@kernel
def _leaving_points(last_left, log_mu, speed_grid, row, speeds, misfit, points, logs):  # type: ignore[no-untyped-def]
    """As `_stop_points` for an event that left, of which only the speeds are known."""
    n_cells = max(last_left, 1)
    at_grid = np.empty(n_cells + 1)
    for j in range(n_cells + 1):
        at_grid[j] = _speed_log(speed_grid, row, speeds, float(j), misfit, np.inf)
    good = np.max(at_grid) - DEPTH
    count = 0
    for j in range(n_cells + 1):
        if j == len(log_mu) - 1 or (at_grid[j] < good and at_grid[min(j + 1, n_cells)] < good):
            continue
        # It leaves up to midway between the last friction at which it does and the next.
        end = 1.0 if j < n_cells else 0.5
        width = log_mu[j + 1] - log_mu[j]
        for p in range(SPEED_PIECES):
            share = end * (p + 0.5) / SPEED_PIECES
            points[count] = log_mu[j] + share * width
            logs[count] = np.log(end * width / SPEED_PIECES)
            logs[count] += _speed_log(speed_grid, row, speeds, j + share, misfit, np.inf)
            count += 1
    return count


@kernel
def _speed_log(grid, row, speeds, j, misfit, room):  # type: ignore[no-untyped-def]
    """Log density of one event's speeds at place j (not a whole number) of the frictions' grid.

    -inf as soon as it must be below `-room`. `misfit` `[n_places]` is scratch.

    Squares of speed, not log densities, are interpolated between the coarse frictions: u² is
    close to straight, while densities fall steeply where the block no longer reaches a place.
    """
    n_coarse, n_places = grid.square.shape[1], grid.square.shape[2]
    c = min(int(j / grid.stride), n_coarse - 2)
    t = min(j / grid.stride - c, 1.0)
    most = 2.0 * (room - grid.log_norm[row])
    total = 0.0
    for a in range(n_places):
        square = (1.0 - t) * grid.square[row, c, a] + t * grid.square[row, c + 1, a]
        misfit[a] = speeds[a] - math.sqrt(max(square, 0.0))
        value = 0.0
        for b in range(a + 1):
            value += grid.whiten[row, a, b] * misfit[b]
        total += value * value
        if total > most:
            return -np.inf
    return -0.5 * total - grid.log_norm[row]
