"""Mean, variance and mass of the likelihood of a stop, over log friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.exponentials import ExpMemory, exp_memory, exponentials
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

REACH = 6.0
"""Errors of the record that a friction's stop may lie from it to count."""
N_POINTS = 256
"""Points that are summed at once; a cell within reach has 13 at most."""
STRETCH = 16
"""Cells of the grid of frictions whose records are looked at only if one can be near."""


def record_bounds(record: NDArray[np.float32]) -> NDArray[np.float32]:
    """Lowest and highest record of each stretch of frictions, `[n_events, n_stretches, 2]`."""
    starts = np.arange(0, max(record.shape[1] - 1, 1), STRETCH)
    low, high = np.minimum.reduceat(record, starts, 1), np.maximum.reduceat(record, starts, 1)
    # A cell reaches to the first point of the next stretch.
    after = record[:, np.minimum(starts + STRETCH, record.shape[1] - 1)]
    return np.stack([np.minimum(low, after), np.maximum(high, after)], axis=2)


class StopMemory(NamedTuple):
    """Working memory for the points of one record: log masses, places, and widths of cells."""

    log_mass: Floats
    place: Floats
    width: Floats
    exp: ExpMemory


@kernel(inner=True)
def stop_memory() -> StopMemory:
    """Working memory for as many points as are summed at once."""
    return StopMemory(
        np.empty(N_POINTS), np.empty(N_POINTS), np.empty(N_POINTS), exp_memory(N_POINTS)
    )


@kernel(inner=True)
def stop_moments(  # type: ignore[no-untyped-def]
    record, bounds, first, observed, sigma, log_mu, hidden_from, bell, memory
):
    """Mean, variance and log mass of the likelihood of a stop without speeds; nan far from any.

    It is taken times a `bell` (`bell_of`). The points are those of `stop_points`, summed as they
    come: no record is so far from them that their masses had to be taken as logs. From log
    friction `hidden_from` on there is no record.
    """
    log_mass, place, widths, exp = memory
    about, per_width = bell
    sums, origin, n = (0.0, 0.0, 0.0), np.nan, 0
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
            width = log_mu[j + 1] - log_mu[j]
            t_low, t_high = 0.0, 1.0
            if abs(z0) > REACH or abs(z1) > REACH or hidden_from < log_mu[j + 1]:
                t_low, t_high = within_reach(z0, z1, (hidden_from - log_mu[j]) / width)
                if t_high <= t_low:
                    continue
            pieces = int(abs(z1 - z0) * (t_high - t_low)) + 1
            step = t_high - t_low
            if pieces > 1:
                step /= pieces
            if np.isnan(origin):
                origin = log_mu[j]
            if n + pieces > N_POINTS:
                sums, n = _with_points(sums, log_mass, place, widths, n, exp), 0
            for p in range(pieces):
                t = t_low + (p + 0.5) * step
                z = z0 + t * (z1 - z0)
                x = log_mu[j] + t * width
                away = (x - about) * per_width
                log_mass[n] = -0.5 * (z * z + away * away)
                place[n] = x - origin
                widths[n] = step * width
                n += 1
    total, by_place, by_square = _with_points(sums, log_mass, place, widths, n, exp)
    if total == 0.0:
        return np.nan, np.nan, np.nan
    by_place /= total
    variance = max(by_square / total - by_place * by_place, 1e-8)
    return origin + by_place, variance, np.log(total) - np.log(sigma) - HALF_LOG_2PI


@kernel(inner=True)
def _with_points(sums, log_mass, place, widths, n, exp):  # type: ignore[no-untyped-def]
    """The sums of masses, and of these times places and their squares, with n points more."""
    total, by_place, by_square = sums
    exponentials(log_mass, n, exp)
    for k in range(n):
        mass = widths[k] * log_mass[k]
        total += mass
        by_place += mass * place[k]
        by_square += mass * place[k] * place[k]
    return total, by_place, by_square


@kernel(inner=True)
def nearest_moments(record, observed, sigma, log_mu, hidden_from):  # type: ignore[no-untyped-def]
    """Mean, variance and log mass where no friction of the table comes near the record."""
    n_seen = max(np.searchsorted(log_mu, hidden_from), 1)
    z = (record[:n_seen] - observed) / sigma
    nearest = np.argmin(np.abs(z))
    log_mass = -0.5 * min(abs(z[nearest]), 100.0) ** 2 - np.log(sigma) - HALF_LOG_2PI - 6.0
    return log_mu[nearest], 1e-6, log_mass


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
