"""What measured speeds say about friction, between the frictions of the tables.

Errors are those of squares of speed (docs/theory/likelihood.md, "Speeds"). The u in the variance 4
u² σ² + 2 σ⁴ is the mean of the measured speed and those beside it: by its own error alone, what was
measured too low would weigh too much. Between two frictions u² is nearly linear in μ.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.quadrature import finest
from avahazard.inference.likelihood.record_nodes import (
    DEPTH,
    REACH,
    hidden_from,
    record_density_nodes,
)
from avahazard.inference.model.friction_model import HALF_LOG_2PI
from avahazard.inference.model.observations import LEFT, Observations, SpeedRecord
from avahazard.kernels import kernel
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU

MAX_REDRAWS = 100


@kernel
def squared(speed, sigma):  # type: ignore[no-untyped-def]
    """Squares of measured speeds (m²/s²) and their standard deviations, `[n_speeds]` each."""
    k = len(speed)
    square, error = np.empty(k), np.empty(k)
    for a in range(k):
        first, end = max(a - 1, 0), min(a + 2, k)
        middle = np.mean(speed[first:end])
        variance = sigma[a] * sigma[a]
        square[a] = speed[a] * speed[a] - variance
        error[a] = np.sqrt(variance * (4.0 * middle * middle + 2.0 * variance))
    return square, error


@kernel
def whitening(speed, sigma, spread, scatter):  # type: ignore[no-untyped-def]
    """Squares of measured speeds `[n_speeds]`, a matrix and a constant for their density.

    The matrix makes what the squares differ from those of the block independent unit errors. The
    log density of the speeds (not of their squares) is less than zero by half the sum of the
    squares of these and the constant. `spread` as in `SpeedRecord`.
    """
    square, error = squared(speed, sigma)
    covariance = scatter * scatter * spread + np.diag(error * error)
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    constant = HALF_LOG_2PI * len(speed) - np.sum(np.log(np.diag(whiten) * error / sigma))
    return square, whiten, constant


@kernel
def speed_log_density(predicted, errors):  # type: ignore[no-untyped-def]
    """Log density of one track's speeds for each row of u² `predicted` `[n_friction, n_speeds]`."""
    measured, whiten, constant = errors
    z = (measured - predicted) @ whiten.T
    return -0.5 * np.sum(z * z, axis=1) - constant


def drawn_speeds(
    square: Floats, track: SpeedRecord, scatter: float, rng: np.random.Generator, arrives: bool
) -> Floats:
    """Measured speeds (m/s) of avalanches whose block has these squares `[n_speeds, n_draws]`.

    Where the block moves (everywhere, for one that `arrives` at its stop), r is drawn again until
    the avalanche moves; if it does so in none of `MAX_REDRAWS`, the least impossible one counts.
    """
    moving = (square > 0.0) | (arrives & (track.share < 1.0))[:, None]
    root = scatter * track.root
    n = square.shape[1]
    true = square + root @ rng.standard_normal((len(square), n))
    lowest = np.min(true, axis=0, where=moving, initial=np.inf)
    for _ in range(MAX_REDRAWS):
        again = np.flatnonzero(lowest <= 0.0)
        if not len(again):
            break
        fresh = square[:, again] + root @ rng.standard_normal((len(square), len(again)))
        low = np.min(fresh, axis=0, where=moving[:, again], initial=np.inf)
        better = low > lowest[again]
        true[:, again[better]] = fresh[:, better]
        lowest[again[better]] = low[better]
    error = track.sigma[:, None] * rng.standard_normal(square.shape)
    return np.asarray(np.sqrt(np.where(moving, np.maximum(true, 0.0), 0.0)) + error)


BESIDE = 4
"""Rows kept beyond the frictions that a record leaves: two go to the fine frictions beside it."""


@kernel
def rows_left(record, left, observed_left, observed, error):  # type: ignore[no-untyped-def]
    """The first and the end of the frictions `[n_friction]` of a track that count.

    They are those whose cells `cell_bounds` may ask for, and `BESIDE` more.
    """
    bound = _by_record(record, left, observed_left, observed, error)
    within = np.flatnonzero(bound >= min(np.max(bound), -0.5 * REACH * REACH))
    return max(within[0] - BESIDE, 0), min(within[-1] + 2 + BESIDE, len(record))


@kernel
def cell_bounds(  # type: ignore[no-untyped-def]
    predicted, cell, at_jump, errors, record, left, observed_left, observed, error
):
    """The most that the log likelihood can be in each cell of frictions `[n_friction - 1]`.

    -inf where the record is out of reach, and where it leaves less than `DEPTH` below the best:
    speeds can add no more than their density at its highest.
    """
    bound = _by_record(record, left, observed_left, observed, error)
    best = np.argmax(bound)
    ends = _at_ends(np.array([best]), predicted, cell, at_jump, errors)
    least = bound[best] + max(ends[best], ends[best + 1]) - DEPTH + errors[2]
    # Beyond reach there are no points of the likelihood: the nearest friction, at most.
    likely = np.flatnonzero(bound >= max(least, min(bound[best], -0.5 * REACH * REACH)))
    ends = _at_ends(likely, predicted, cell, at_jump, errors)
    found = np.full(len(bound), -np.inf)
    found[likely] = bound[likely] + np.maximum(ends[likely], ends[likely + 1])
    if not np.isfinite(np.max(found)):
        found[likely] = 0.0
    return found


@kernel
def _by_record(record, left, observed_left, observed, error):  # type: ignore[no-untyped-def]
    """The most that the record alone leaves each cell of frictions `[n_friction - 1]`, a log."""
    n = len(record) - 1
    bound = np.zeros(n)
    for j in range(n):
        if observed_left:
            if not (left[j] or left[j + 1]):
                bound[j] = -np.inf
        elif left[j] and left[j + 1]:
            bound[j] = -np.inf
        else:
            z0, z1 = (record[j] - observed) / error, (record[j + 1] - observed) / error
            if z0 * z1 > 0.0:
                bound[j] -= 0.5 * min(abs(z0), abs(z1)) ** 2
    return bound


@kernel
def _at_ends(cells, predicted, cell, at_jump, errors):  # type: ignore[no-untyped-def]
    """Log density of the speeds at the ends of these cells, `[n_friction]`; -inf elsewhere.

    In `cell` the block that passes comes as slow as `at_jump`; so does all between it and the next.
    """
    asked = np.zeros(len(predicted), dtype=np.bool_)
    for j in cells:
        asked[j], asked[j + 1] = True, True
    rows = np.flatnonzero(asked)
    square = predicted[rows] ** 2
    for k in range(len(rows)):
        if rows[k] == cell:
            square[k] = at_jump
    result = np.full(len(predicted), -np.inf)
    result[rows] = speed_log_density(square, errors)
    return result


class TrackRows(NamedTuple):
    """What was measured on a track, and what blocks do at the frictions that its record leaves.

    `event`, `speed`, `sigma` `[n_speeds]` and `spread` are those of its `SpeedRecord`. `grid`
    `[n_rows]` are the frictions; `record`, `left` `[n_rows]`, `speeds` `[n_rows, n_speeds]` (m/s)
    the tables there, `cell`, which counts from the first row, and `at_jump` `[n_speeds]` those of
    `TrackSpeeds`. `observed_left`, `observed`, `error` are those of the record; `unseen_from` is
    the friction above which stops are undetected.
    """

    event: int
    speed: Floats
    sigma: Floats
    spread: Floats
    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    speeds: Floats
    cell: int
    at_jump: Floats
    observed_left: bool
    observed: float
    error: float
    unseen_from: float


def track_rows(observations: Observations, predicted: Predicted) -> list[TrackRows]:
    """The rows of the tables that the record of each track leaves, with some beyond."""
    unseen_from = hidden_from(observations, predicted, in_log=False)
    tracks = []
    for track, block in zip(observations.speeds, predicted.speeds, strict=True):
        i = track.event
        record, left = predicted.record[i], predicted.status[i] == LEFT_PROFILE
        observed_left = bool(observations.kind[i] == LEFT)
        observed, error = float(observations.observed[i]), float(predicted.sigma[i])
        first, end = rows_left(record, left, observed_left, observed, error)
        some, cell = slice(first, end), block.cell - first if block.cell >= 0 else -1
        measured = i, track.speed, track.sigma, track.spread
        # Copies: the tables themselves are large.
        tables = MU[some], record[some].copy(), left[some].copy(), block.speed[some].copy()
        stop = observed_left, observed, error, float(unseen_from[i])
        tracks.append(TrackRows(*measured, *tables, cell, block.at_jump, *stop))
    return tracks


SPLIT, POINTS = 15, 128
"""Parts of each cell of the friction grid (odd: a block that leaves does so up to the middle of
a cell); fewer where that many points are there without."""


class FineTrack(NamedTuple):
    """One event at fine frictions: `grid`, `record`, `left`, `square` `[n_fine(, n_speeds)]`."""

    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    square: Floats


def fill_track_nodes(
    track: TrackRows,
    scatter: float,
    panels: int,
    in_log: bool,
    place: Floats,
    weight: Floats,
    tail: Floats,
) -> float:
    """Fill in the nodes of a track, with `scatter` of friction along it; the log of their mass."""
    fine, log_speed, grid, unseen_from = likely_frictions(track, scatter, in_log)
    stops = fine.record, fine.left, track.observed_left, track.observed, track.error
    within = log_speed, grid, unseen_from, panels, finest(in_log)
    log_mass = record_density_nodes(*stops, *within, place, weight, tail)
    # Frictions that the speeds rule out lie beyond the fine ones.
    if fine.grid[0] > MU[0]:
        tail[0] = 0.0
    if fine.grid[-1] < MU[-1]:
        tail[1] = 0.0
    return float(log_mass)


@kernel
def likely_frictions(track, scatter, in_log):  # type: ignore[no-untyped-def]
    """The tables of one of `TrackRows` over fine frictions (`between`), and its speeds there.

    Of these the log density `[n_fine]`, with `scatter` of friction along the track. And the fine
    frictions `[n_fine]` and the one from which on stops are undetected, or their logs.
    """
    errors = whitening(track.speed, track.sigma, track.spread, scatter)
    predicted = track.speeds, track.cell, track.at_jump, errors, track.record, track.left
    bound = cell_bounds(*predicted, track.observed_left, track.observed, track.error)
    hidden = track.grid[:-1] >= track.unseen_from
    if not np.all(hidden):
        bound[hidden] = -np.inf
    tables = track.grid, track.record, track.left, track.speeds, track.cell, track.at_jump
    fine = between(*tables, bound, track.observed_left)
    log_speed = speed_log_density(fine.square, errors)
    if in_log:
        return fine, log_speed, np.log(fine.grid), np.log(track.unseen_from)
    return fine, log_speed, fine.grid, track.unseen_from


@kernel
def between(  # type: ignore[no-untyped-def]
    mu, record, left, speeds, cell, at_jump, log_likelihood, observed_left
):
    """Tables of one event `[n_friction(, n_speeds)]` over finer frictions about the likely ones.

    `log_likelihood` `[n_friction - 1]` bounds what each cell of the grid `mu` can hold. Where the
    block stops short of a place in the next friction, its u² is carried on from the cell before;
    in the `cell` over which F jumps, u² is `at_jump` `[n_speeds]`.
    """
    good = np.flatnonzero(log_likelihood > np.max(log_likelihood) - DEPTH)
    first, last = max(good[0] - 1, 0), min(good[-1] + 2, len(mu) - 1)
    split = 2 * (max(2, min(SPLIT, POINTS // len(good))) // 2) + 1
    n, n_places = split * (last - first) + 1, speeds.shape[1]
    grid, fine_record = np.empty(n), np.empty(n)
    fine_left, square = np.empty(n, dtype=np.bool_), np.empty((n, n_places))
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
                if j == cell:
                    square[row, a] = at_jump[a]
                else:
                    square[row, a] = max(speeds[j, a] ** 2 + share * rise[a], 0.0)
    grid[n - 1], fine_record[n - 1], fine_left[n - 1] = mu[last], record[last], left[last]
    square[n - 1] = speeds[last] ** 2
    if last == cell:
        square[n - 1] = at_jump
    return FineTrack(grid, fine_record, fine_left, square)
