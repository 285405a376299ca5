"""Points of the likelihood of events with measured speeds, over log friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import kernel

REACH = 6.0
"""Errors of the record that a friction's stop may lie from it to count."""
STRETCH = 16
"""Cells of the grid of frictions whose records are looked at only if one can be near."""
SPEED_PIECES = 4
"""Parts of a cell of frictions where speeds tell them apart."""
DEPTH = 20.0
"""Frictions whose log density is that much below the best are left out: means and variances, which
is all that is asked for, have nothing of them."""
AHEAD = 8
"""Every so many cells one point is tried first, so that most others are known to be out of it."""


class SpeedGrid(NamedTuple):
    """Speeds predicted for the events that have measured ones, one set of tables.

    `row` `[n_events]` points to the event's row, -1 for none; `square` `[n_rows, n_coarse,
    n_places]` is u² at every `stride`-th friction, below 0 where the block stops short; `cell`
    `[n_rows]` and `jumped` `[n_rows, n_places]` are what `JumpedStop` has. `sigma` `[n_rows,
    n_places]` and `scatter` (of friction along the tracks) are those of `speed_errors`.
    """

    row: NDArray[np.int64]
    square: NDArray[np.float32]
    stride: int
    cell: NDArray[np.int64]
    jumped: Floats
    sigma: Floats
    scatter: float


class Tracks(NamedTuple):
    """The speeds (m/s) that were measured in one dataset, `[n_rows, n_places]`.

    `places` `[n_rows]` says at how many places, the first: those that the avalanche came to.
    `spread` `[n_rows, n_places, n_places]` as in `SpeedRecord`, by where it stopped.
    """

    speed: Floats
    places: NDArray[np.int64]
    spread: Floats


@kernel(inner=True)
def stop_points(  # type: ignore[no-untyped-def]
    record,
    bounds,
    first,
    observed,
    sigma,
    log_mu,
    hidden_from,
    speed_grid,
    row,
    errors,
    misfit,
    points,
    logs,
):
    """Points of the likelihood of a stop with speeds, and their log masses; returns how many.

    From log friction `hidden_from` on there is no record; `errors` are the measured speeds of the
    event as `speed_errors.whitening` gives them.
    """
    count = 0
    best = _some_point(
        record, first, observed, sigma, log_mu, hidden_from, speed_grid, row, errors, misfit
    )
    scale = 1.0 / sigma
    coarse, straight, bend = -1, False, (0.0, 0.0, 0.0)
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
            width = log_mu[j + 1] - log_mu[j]
            # Only the part of the cell within reach counts.
            t_low, t_high = within_reach(z0, z1, (hidden_from - log_mu[j]) / width)
            if t_high <= t_low:
                continue
            pieces = max(int(abs(z1 - z0) * (t_high - t_low)) + 1, SPEED_PIECES)
            step = (t_high - t_low) / pieces
            log_width = np.log(step * width)
            if _coarse(speed_grid, float(j)) != coarse:
                coarse = _coarse(speed_grid, float(j))
                straight, bend = _parabola(speed_grid, row, errors, coarse, misfit)
            by_parabola = straight and j != speed_grid.cell[row]
            if by_parabola and log_width - _least(bend) - errors[2] < best - DEPTH:
                continue
            for p in range(pieces):
                if count == len(points):
                    return count
                t = t_low + (p + 0.5) * step
                z = z0 + t * (z1 - z0)
                points[count] = log_mu[j] + t * width
                logs[count] = log_width - 0.5 * z * z
                if by_parabola:
                    share = min((j + t) / speed_grid.stride - coarse, 1.0)
                    logs[count] -= bend[0] + share * (bend[1] + share * bend[2]) + errors[2]
                else:
                    room = logs[count] - best + DEPTH
                    logs[count] += _speed_log(speed_grid, row, errors, j + t, misfit[0], room)
                if logs[count] < best - DEPTH:
                    continue
                best = max(best, logs[count])
                count += 1
    return count


@kernel(inner=True)
def _some_point(  # type: ignore[no-untyped-def]
    record, first, observed, sigma, log_mu, hidden_from, speed_grid, row, errors, misfit
):
    """Log mass of the likeliest of a few points of `stop_points`, -inf if there is none."""
    best = -np.inf
    for j in range(first, len(record) - 1, AHEAD):
        z = (record[j] - observed) / sigma
        if abs(z) < REACH and log_mu[j] < hidden_from:
            step = (log_mu[j + 1] - log_mu[j]) / SPEED_PIECES
            log_mass = np.log(step) - 0.5 * z * z
            room = log_mass - best + DEPTH
            at_grid = _speed_log(speed_grid, row, errors, float(j), misfit[0], room)
            best = max(best, log_mass + at_grid)
    # A point beside it must not be lost for it.
    return best - 0.5 * DEPTH


@kernel(inner=True)
def leaving_points(last_left, log_mu, speed_grid, row, errors, misfit, points, logs):  # type: ignore[no-untyped-def]
    """As `stop_points` for an event that left, of which only the speeds are known."""
    n_cells = max(last_left, 1)
    at_grid = np.empty(n_cells + 1)
    for j in range(n_cells + 1):
        at_grid[j] = _speed_log(speed_grid, row, errors, float(j), misfit[0], np.inf)
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
            logs[count] += _speed_log(speed_grid, row, errors, j + share, misfit[0], np.inf)
            count += 1
    return count


@kernel(inner=True)
def _speed_log(grid, row, errors, j, misfit, room):  # type: ignore[no-untyped-def]
    """Log density of one event's speeds at place j (not a whole number) of the frictions' grid.

    -inf as soon as it must be below `-room`. `misfit` `[n_places]` is scratch.

    Squares of speed, not log densities, are interpolated between the coarse frictions: u² is
    close to straight, while densities fall steeply where the block no longer reaches a place. In
    the cell over which F jumps the block comes as slow as `grid.jumped`.
    """
    measured, whiten, log_norm = errors
    n_places = len(measured)
    c = _coarse(grid, j)
    t = min(j / grid.stride - c, 1.0)
    most = 2.0 * (room - log_norm)
    jumps = int(j) == grid.cell[row]
    total = 0.0
    for a in range(n_places):
        square = (1.0 - t) * grid.square[row, c, a] + t * grid.square[row, c + 1, a]
        misfit[a] = measured[a] - (grid.jumped[row, a] if jumps else max(square, 0.0))
        value = 0.0
        for b in range(a + 1):
            value += whiten[a, b] * misfit[b]
        total += value * value
        if total > most:
            return -np.inf
    return -0.5 * total - log_norm


@kernel(inner=True)
def _coarse(grid, j):  # type: ignore[no-untyped-def]
    """The coarse friction at or before place j of the frictions' grid, the last but one at most."""
    return min(int(j / grid.stride), grid.square.shape[1] - 2)


@kernel(inner=True)
def _parabola(grid, row, errors, c, misfit):  # type: ignore[no-untyped-def]
    """The same from coarse friction c to the next, less its norm: a + t (b + t c'), t in [0, 1].

    Squares of speed are straight there, so that what they are off by, squared, is a parabola. Not
    where the block stops short of a place; then False comes first. `misfit` `[2, n_places]` is
    scratch.
    """
    measured, whiten, _ = errors
    at, along, bend = 0.0, 0.0, 0.0
    for a in range(len(measured)):
        low, high = float(grid.square[row, c, a]), float(grid.square[row, c + 1, a])
        if low < 0.0 or high < 0.0:
            return False, (0.0, 0.0, 0.0)
        misfit[0, a], misfit[1, a] = measured[a] - low, low - high
        value, slope = 0.0, 0.0
        for b in range(a + 1):
            value += whiten[a, b] * misfit[0, b]
            slope += whiten[a, b] * misfit[1, b]
        at += value * value
        along += value * slope
        bend += slope * slope
    return True, (0.5 * at, along, 0.5 * bend)


@kernel(inner=True)
def _least(bend):  # type: ignore[no-untyped-def]
    """The least value of a `_parabola`."""
    a, b, c = bend
    t = min(max(-0.5 * b / c, 0.0), 1.0) if c > 0.0 else (1.0 if b < 0.0 else 0.0)
    return a + t * (b + t * c)


@kernel(inner=True)
def within_reach(z0, z1, seen):  # type: ignore[no-untyped-def]
    """The part of a cell, from z0 to z1 standard deviations, that is within reach; 0 to 0 if none.

    It ends at the share `seen` of the cell.
    """
    if (z0 > REACH and z1 > REACH) or (z0 < -REACH and z1 < -REACH):
        return 0.0, 0.0
    if z0 == z1:
        return 0.0, min(1.0, seen)
    ta = (-REACH - z0) / (z1 - z0)
    tb = (REACH - z0) / (z1 - z0)
    return max(0.0, min(ta, tb)), min(1.0, seen, max(ta, tb))
