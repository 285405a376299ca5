"""What each record says about friction in brief: mean, variance and mass of its likelihood.

The screening fits thousands of made worlds; there the likelihood p(record | μ) over ν = log μ is
taken as normal, which needs no nodes. The mass holds the Jacobian |dν/dF| without which a
regression of back-calculated friction finds effects in pure noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.bell import bell_of, without_bell
from avahazard.criticism.screening.speed_points import leaving_points, stop_points
from avahazard.criticism.screening.stop_moments import nearest_moments, stop_memory, stop_moments
from avahazard.inference.likelihood.speed_errors import whitening
from avahazard.inference.likelihood.straight_density import straight_points
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

MOST_POINTS = 4096


class RecordMoments(NamedTuple):
    """Per event `[n_events]`: mean and variance in ν, and log mass."""

    mean: Floats
    variance: Floats
    log_mass: Floats


NOTHING = RecordMoments(np.empty(0), np.empty(0), np.empty(0))
"""Moments of no events."""


@kernel
def record_moments(  # type: ignore[no-untyped-def]
    record,
    bounds,
    last_left,
    hidden_from,
    about,
    height,
    observed,
    sigma,
    left,
    log_mu,
    speed_grid,
    tracks,
    known,
):
    """RecordMoments of all events; those without speeds are taken from `known`, if not empty.

    `record` `[n_events, n_friction]` is what would be recorded, `bounds` its `record_bounds`,
    `height` `[n_events]` the height of fall of events without a profile (else nan),
    `last_left` `[n_events]` the last friction of the grid at which the block leaves (-1: none),
    `hidden_from` `[n_events]` the log friction from which on stops are not seen (inf: none),
    `about` `[n_events]` the log friction about which likelihoods must be right (nan: anywhere),
    `left` `[n_events]` the events that did leave (for these the speeds alone speak), `tracks` are
    `Tracks`.
    """
    n = len(record)
    mean = np.zeros(n)
    variance = np.zeros(n)
    log_mass = np.zeros(n)
    points = np.empty(MOST_POINTS)
    logs = np.empty(MOST_POINTS)
    misfit = np.empty((2, speed_grid.square.shape[2]))
    memory = stop_memory()
    for i in range(n):
        row = speed_grid.row[i]
        if row >= 0 and tracks.places[row] == 0:
            row = -1
        if row < 0 and len(known.mean):
            mean[i], variance[i], log_mass[i] = known.mean[i], known.variance[i], known.log_mass[i]
            continue
        if left[i] and row < 0:
            continue
        if left[i]:
            errors = _errors(speed_grid, row, tracks)
            count = leaving_points(
                last_left[i], log_mu, speed_grid, row, errors, misfit, points, logs
            )
            log_norm = 0.0
        elif not np.isnan(height[i]):
            count = straight_points(height[i], observed[i], sigma[i], True, True, points, logs)
            log_norm = 0.0
        elif row < 0:
            first, bell = max(last_left[i], 0), bell_of(about[i])
            found = stop_moments(
                record[i],
                bounds[i],
                first,
                observed[i],
                sigma[i],
                log_mu,
                hidden_from[i],
                bell,
                memory,
            )
            if np.isnan(found[0]):
                found = nearest_moments(record[i], observed[i], sigma[i], log_mu, hidden_from[i])
            else:
                found = without_bell(found[0], found[1], found[2], about[i])
            mean[i], variance[i], log_mass[i] = found
            continue
        else:
            count = stop_points(
                record[i],
                bounds[i],
                max(last_left[i], 0),
                observed[i],
                sigma[i],
                log_mu,
                hidden_from[i],
                speed_grid,
                row,
                _errors(speed_grid, row, tracks),
                misfit,
                points,
                logs,
            )
            log_norm = -np.log(sigma[i]) - HALF_LOG_2PI
        if count == 0:
            nearest = nearest_moments(record[i], observed[i], sigma[i], log_mu, hidden_from[i])
            mean[i], variance[i], log_mass[i] = nearest
            continue
        found = _points_moments(points[:count], logs[:count], bell_of(about[i]))
        mean[i], variance[i], log_mass[i] = without_bell(
            found[0], found[1], found[2] + log_norm, about[i]
        )
    return RecordMoments(mean, variance, log_mass)


@kernel(inner=True)
def _points_moments(points, logs, bell):  # type: ignore[no-untyped-def]
    """Mean, variance and log mass of points of a likelihood times the bell; changes `logs`."""
    for c in range(len(points)):
        logs[c] -= 0.5 * ((points[c] - bell[0]) * bell[1]) ** 2
    top = np.max(logs)
    total, first, second = 0.0, 0.0, 0.0
    for c in range(len(points)):
        a = np.exp(logs[c] - top)
        x = points[c] - points[0]
        total += a
        first += a * x
        second += a * x * x
    variance = max(second / total - (first / total) ** 2, 1e-8)
    return points[0] + first / total, variance, top + np.log(total)


@kernel
def _errors(grid, row, tracks):  # type: ignore[no-untyped-def]
    """The measured speeds of one row as `whitening` gives them."""
    k = tracks.places[row]
    return whitening(tracks.speed[row, :k], grid.sigma[row, :k], tracks.spread[row], grid.scatter)
