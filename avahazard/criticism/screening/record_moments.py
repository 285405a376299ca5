"""What each record says about friction in brief: mean, variance and mass of its likelihood.

The screening fits thousands of simulated datasets; there the likelihood p(record | μ) over ν = log
μ is taken as normal, which needs no nodes. The mass holds the Jacobian |dν/dF| without which a
regression of back-calculated friction finds effects in pure noise.

A record on flat ground, or of a block that an effect holds back whatever its friction, says that
friction is below some value and no more. The mean and the variance of such a likelihood are those
of a normal that lets in what it rules out: of 20,000 events cohesion of 2.2 m/s² gained 11 nats
that way, and loses 367. So moments are taken of the likelihood times a window where friction is
expected, and the window is taken out of them (a step of expectation propagation, Minka 2001).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Edges
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords
from avahazard.criticism.screening.speed_points import (
    REACH,
    STRETCH,
    leaving_points,
    stop_points,
    within_reach,
)
from avahazard.criticism.screening.tables import LOG_MU, Tables
from avahazard.inference.likelihood.density_sums import ExpMemory, exp_memory, exponentials
from avahazard.inference.likelihood.record_nodes import straight_points
from avahazard.inference.likelihood.track_nodes import whitening
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.inference.model.observations import PLACE, Observations
from avahazard.kernels import kernel

MOST_POINTS = 4096
N_POINTS = 256
"""Points that are summed at once; a cell within reach has 13 at most."""
WIDTH = 0.5
"""Standard deviation of the window, in log friction: some times the scatter of friction."""
FLATTEST = 0.1
"""Least precision of what is left: what is flatter tells nothing."""
STEEPNESS = 0.5
"""Slope by which a height becomes a distance where places x are recorded."""


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
    `hidden_from` `[n_events]` the log friction from which on stops are not detected (inf: none),
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
            first, window = max(last_left[i], 0), window_of(about[i])
            found = stop_moments(
                record[i],
                bounds[i],
                first,
                observed[i],
                sigma[i],
                log_mu,
                hidden_from[i],
                window,
                memory,
            )
            if np.isnan(found[0]):
                found = nearest_moments(record[i], observed[i], sigma[i], log_mu, hidden_from[i])
            else:
                found = without_window(found[0], found[1], found[2], about[i])
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
        found = _points_moments(points[:count], logs[:count], window_of(about[i]))
        mean[i], variance[i], log_mass[i] = without_window(
            found[0], found[1], found[2] + log_norm, about[i]
        )
    return RecordMoments(mean, variance, log_mass)


@kernel(inner=True)
def _points_moments(points, logs, window):  # type: ignore[no-untyped-def]
    """Mean, variance and log mass of points of a likelihood times the window; changes `logs`."""
    for c in range(len(points)):
        logs[c] -= 0.5 * ((points[c] - window[0]) * window[1]) ** 2
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
    record, bounds, first, observed, sigma, log_mu, hidden_from, window, memory
):
    """Mean, variance and log mass of the likelihood of a stop without speeds; nan far from any.

    It is taken times a `window` (`window_of`). The points are those of `stop_points`, summed as
    they come: no record is so far from them that their masses had to be taken as logs. From log
    friction `hidden_from` on there is no record.
    """
    log_mass, place, widths, exp = memory
    about, per_width = window
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
def window_of(about):  # type: ignore[no-untyped-def]
    """Where the window stands, and the inverse of its width; 0 and 0 for none (nan)."""
    if np.isnan(about):
        return 0.0, 0.0
    return about, 1.0 / WIDTH


@kernel(inner=True)
def without_window(mean, variance, log_mass, about):  # type: ignore[no-untyped-def]
    """The moments of a likelihood which, times the window `about` a log friction, has these."""
    if np.isnan(about):
        return mean, variance, log_mass
    own = 1.0 / max(1.0 / variance - WIDTH**-2, FLATTEST)
    place = mean + (mean - about) * own / WIDTH**2
    both = own + WIDTH**2
    lost = 0.5 * np.log(both / WIDTH**2) + 0.5 * (place - about) ** 2 / both
    return place, own, log_mass + lost


def detection_edges(
    tables: Tables, margin: float, measured: BootstrapRecords, observations: Observations
) -> Edges:
    """Edges where stops `margin` (m) above the highest of each path are not detected."""
    limit = estimated_limits(observations, measured, margin)
    n = len(limit)
    silent = tables.speeds._replace(row=np.full(n, -1, dtype=np.int64))
    anywhere = replace(
        tables, hidden_from=np.full(n, np.inf), about=np.full(n, np.nan), speeds=silent
    )
    at_limit = replace(measured, observed=np.nan_to_num(limit), left=np.zeros(n, dtype=np.bool_))
    place = moments_of(anywhere, at_limit)
    known = tables.edges
    declared = np.isfinite(observations.limit)
    estimated = np.isfinite(limit) & ~declared & (observations.columns.path_index >= 0)
    return known._replace(
        detected=np.where(declared, known.detected, place.mean),
        detected_sd=np.where(declared, known.detected_sd, np.sqrt(place.variance)),
        has_limit=np.where(declared, known.has_limit, estimated),
    )


def estimated_limits(
    observations: Observations, measured: BootstrapRecords, margin: float
) -> Floats:
    """Stops from which on nobody looks `[n_events]`: the declared ones, else `margin` (m) above.

    Above the highest stop of the same kind of record on the path; nan where there is none.
    """
    path = observations.columns.path_index
    of_a_path = (path >= 0) & np.isnan(observations.limit)
    limit = observations.limit.copy()
    in_x = observations.kind == PLACE
    for kind, sign in ((in_x, -1.0), (~in_x, 1.0)):
        highest = np.full(len(observations.columns.paths), -np.inf)
        stopped = of_a_path & kind & ~measured.left
        np.maximum.at(highest, path[stopped], sign * measured.observed[stopped])
        known = of_a_path & kind
        known[known] = np.isfinite(highest[path[known]])
        height = margin / (STEEPNESS if sign < 0 else 1.0)
        limit[known] = sign * (highest[path[known]] + height)
    return limit


def moments_of(
    tables: Tables, measured: BootstrapRecords, known: RecordMoments = NOTHING
) -> RecordMoments:
    """RecordMoments of one dataset under one set of tables.

    They are `known` where these differ by the scatter along tracks alone, but for speeds.
    """
    moments: RecordMoments = record_moments(
        tables.record,
        tables.bounds,
        tables.last_left,
        tables.hidden_from,
        tables.about,
        tables.height,
        measured.observed,
        tables.sigma,
        measured.left,
        LOG_MU,
        tables.speeds,
        measured.tracks,
        known,
    )
    return moments
