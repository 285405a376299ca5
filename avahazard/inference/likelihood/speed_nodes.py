"""What measured speeds say about friction between the frictions of the tables.

Speeds tell friction more closely than the tables are spaced. Between two frictions u² is nearly
linear in μ (exactly so where nothing but the drive depends on it), unlike u near the stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.record_density import DEPTH, record_density_nodes
from avahazard.inference.likelihood.speed_errors import whitening
from avahazard.inference.model.observations import SpeedRecord
from avahazard.kernels import kernel

Floats = NDArray[np.float64]

SPLIT, POINTS = 15, 256
"""Parts of each cell of the friction grid (odd: a block that leaves does so up to the middle of
a cell); fewer where that many points are there without."""


class MeasuredSpeeds(NamedTuple):
    """Speeds of all tracks end to end.

    `x`, `speed`, `sigma` `[n_speeds]`; those of `event[k]` begin at `first[k]` and end before
    `end[k]`.
    """

    event: NDArray[np.int64]
    first: NDArray[np.int64]
    end: NDArray[np.int64]
    x: Floats
    speed: Floats
    sigma: Floats


class FineTrack(NamedTuple):
    """One event at fine frictions: `grid`, `record`, `left`, `speeds` `[n_fine(, n_speeds)]`."""

    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    speeds: Floats


def measured_speeds(records: Sequence[SpeedRecord]) -> MeasuredSpeeds:
    """The records of speeds end to end, as the kernels want them."""
    bounds = np.cumsum([0, *(len(r.x) for r in records)])
    return MeasuredSpeeds(
        event=np.array([r.event for r in records]),
        first=bounds[:-1],
        end=bounds[1:],
        x=np.concatenate([r.x for r in records]),
        speed=np.concatenate([r.speed for r in records]),
        sigma=np.concatenate([r.sigma for r in records]),
    )


def squares(speeds: Floats) -> Floats:
    """u² `[n_friction, n_places]`, carried on to the first friction that stops short of a place.

    Straight and below 0, so that the stop has its place between this friction and the one before.
    """
    square = speeds**2
    stops = np.flatnonzero(np.diff(speeds == 0.0, axis=0).any(axis=1)) + 1
    for c in stops[stops > 1]:
        short = (speeds[c] == 0.0) & (speeds[c - 1] > 0.0)
        ahead = 2.0 * square[c - 1] - square[c - 2]
        square[c] = np.where(short, np.minimum(ahead, 0.0), square[c])
    return np.asarray(square)


@kernel
def between(mu, record, left, speeds, log_likelihood, observed_left):  # type: ignore[no-untyped-def]
    """Tables of one event `[n_friction(, n_speeds)]` over finer frictions about the likely ones.

    `log_likelihood` `[n_friction - 1]` bounds what each cell of the grid `mu` can hold. Where the
    block stops short of a place in the next friction, its u² is carried on from the cell before.
    """
    good = np.flatnonzero(log_likelihood > np.max(log_likelihood) - DEPTH)
    first, last = max(good[0] - 1, 0), min(good[-1] + 2, len(mu) - 1)
    split = 2 * (max(2, min(SPLIT, POINTS // len(good))) // 2) + 1
    n, n_places = split * (last - first) + 1, speeds.shape[1]
    grid, fine_record = np.empty(n), np.empty(n)
    fine_left, fine_speeds = np.empty(n, dtype=np.bool_), np.empty((n, n_places))
    rise = np.empty(n_places)
    for j in range(first, last):
        for a in range(n_places):
            low, high = speeds[j, a] ** 2, speeds[j + 1, a] ** 2
            rise[a] = high - low
            if high == 0.0 and low > 0.0 and j > 0:
                rise[a] = low - speeds[j - 1, a] ** 2
        for k in range(split):
            share, row = k / split, split * (j - first) + k
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
    return FineTrack(grid, fine_record, fine_left, fine_speeds)


@kernel
def fill_speed_nodes(  # type: ignore[no-untyped-def]
    measured,
    predicted,
    scatter,
    mu,
    record,
    left,
    observed_left,
    observed,
    error,
    in_log,
    panels,
    finest,
    nodes,
):
    """Fill in place, weight, tail and log scale (`nodes`) of the events with speeds.

    `measured` are `MeasuredSpeeds`, `predicted` `[n_friction, n_speeds]` the block's (m/s)
    with the model's own error `scatter`; the others `[n_events(, n_friction)]` as in `nodes`.
    """
    for k in range(len(measured.event)):
        i, a, b = measured.event[k], measured.first[k], measured.end[k]
        speed, mine = measured.speed[a:b], predicted[:, a:b]
        errors = whitening(measured.x[a:b], measured.sigma[a:b], scatter)
        ends = _log_density(speed, mine, errors)
        bound = _bound(ends, record[i], left[i], observed_left[i], observed[i], error[i])
        track = between(mu, record[i], left[i], mine, bound, observed_left[i])
        nodes.log_scale[i] = record_density_nodes(
            track.record,
            track.left,
            observed_left[i],
            observed[i],
            error[i],
            _log_density(speed, track.speeds, errors),
            np.log(track.grid) if in_log else track.grid,
            panels[i],
            finest,
            nodes.place[i],
            nodes.weight[i],
            nodes.tail[i],
        )
        # Frictions that the speeds rule out lie beyond the fine ones.
        if track.grid[0] > mu[0]:
            nodes.tail[i, 0] = 0.0
        if track.grid[-1] < mu[-1]:
            nodes.tail[i, 1] = 0.0


@kernel
def _bound(ends, record, left, observed_left, observed, error):  # type: ignore[no-untyped-def]
    """The most that the log likelihood can be in each cell of frictions `[n_friction - 1]`."""
    n = len(ends) - 1
    bound = np.empty(n)
    for j in range(n):
        bound[j] = max(ends[j], ends[j + 1])
        if observed_left:
            if not (left[j] or left[j + 1]):
                bound[j] = -np.inf
        elif left[j] and left[j + 1]:
            bound[j] = -np.inf
        else:
            z0, z1 = (record[j] - observed) / error, (record[j + 1] - observed) / error
            if z0 * z1 > 0.0:
                bound[j] -= 0.5 * min(abs(z0), abs(z1)) ** 2
    if not np.isfinite(np.max(bound)):
        bound[:] = 0.0
    return bound


def speed_log_likelihood(
    x: Floats, speed: Floats, sigma: Floats, predicted: Floats, scatter: float
) -> Floats:
    """Log density of the speeds of one track given each friction, `[n_friction]`.

    `x` (m), `sigma` `[n_speeds]` and `scatter` as in `speed_errors`; `predicted`
    `[n_friction, n_speeds]`, all in m/s.
    """
    return np.asarray(_log_density(speed, predicted, whitening(x, sigma, scatter)))


@kernel
def _log_density(speed, predicted, errors):  # type: ignore[no-untyped-def]
    """Log density of one track's speeds for each row of `predicted` `[n_friction, n_speeds]`."""
    whiten, constant = errors
    k = len(speed)
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
