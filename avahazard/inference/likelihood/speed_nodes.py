"""What measured speeds say about friction between the frictions of the tables.

Speeds tell friction more closely than the tables are spaced. Between two frictions u² is nearly
linear in μ (exactly so where nothing but the drive depends on it), unlike u near the stop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.panels import finest, nodes_used
from avahazard.inference.likelihood.record_density import DEPTH, record_density_nodes
from avahazard.inference.likelihood.speed_bounds import cell_bounds
from avahazard.inference.likelihood.speed_errors import speed_log_density, whitening
from avahazard.inference.likelihood.track_tables import TrackTables
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import MU
from avahazard.workers import n_workers, ordered_map

SPLIT, POINTS = 15, 128
"""Parts of each cell of the friction grid (odd: a block that leaves does so up to the middle of
a cell); fewer where that many points are there without."""


class TrackNodes(NamedTuple):
    """Nodes of the tracks as in `nodes.Nodes`.

    `place`, `weight` `[n_tracks, n_nodes]`, `tail` `[n_tracks, 2]`, `log_scale` `[n_tracks]`.
    """

    place: Floats
    weight: Floats
    tail: Floats
    log_scale: Floats


class FineTrack(NamedTuple):
    """One event at fine frictions: `grid`, `record`, `left`, `square` `[n_fine(, n_speeds)]`."""

    grid: Floats
    record: Floats
    left: NDArray[np.bool_]
    square: Floats


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


def track_nodes(tables: TrackTables, scatter: float, panels: Ints, in_log: bool) -> TrackNodes:
    """Nodes of all tracks with this `scatter` of friction along them; `panels` `[n_tracks]`."""
    n = len(panels)
    shape = n, int(np.max(nodes_used(panels)))
    nodes = TrackNodes(np.zeros(shape), np.zeros(shape), np.zeros((n, 2)), np.zeros(n))

    def fill(part: NDArray[np.int64]) -> None:
        fill_speed_nodes(tables, part, scatter, MU, in_log, panels, finest(in_log), nodes)

    list(ordered_map(fill, np.array_split(np.arange(n), min(n_workers(), n))))
    return nodes


@kernel
def fill_speed_nodes(tables, tracks, scatter, mu, in_log, panels, finest, nodes):  # type: ignore[no-untyped-def]
    """Fill in the `TrackNodes` of `tracks`, with `scatter` of friction along them.

    `tables` are `TrackTables`, `mu` `[n_friction]` the frictions of the tables.
    """
    measured = tables.measured
    for k in tracks:
        a, b = measured.first[k], measured.end[k]
        first, begin, stop = tables.first[k], tables.begin[k], tables.begin[k + 1]
        grid = mu[first : first + stop - begin]
        record, left = tables.record[begin:stop], tables.left[begin:stop]
        observed_left = tables.observed_left[k]
        observed, error = tables.observed[k], tables.error[k]
        mine, jumped = tables.speeds[begin:stop, : b - a], measured.jumped[a:b]
        cell = measured.cell[k] - first if measured.cell[k] >= 0 else -1
        size, start = b - a, measured.first_spread[k]
        spread = measured.spread[start : start + size * size].reshape((size, size))
        errors = whitening(measured.speed[a:b], measured.sigma[a:b], spread, scatter)
        told = mine, cell, jumped, errors, record, left
        bound = cell_bounds(*told, observed_left, observed, error)
        hidden = grid[:-1] >= tables.hidden_from[k]
        if not np.all(hidden):
            bound[hidden] = -np.inf
        track = between(grid, record, left, mine, cell, jumped, bound, observed_left)
        nodes.log_scale[k] = record_density_nodes(
            track.record,
            track.left,
            observed_left,
            observed,
            error,
            speed_log_density(track.square, errors),
            np.log(track.grid) if in_log else track.grid,
            np.log(tables.hidden_from[k]) if in_log else tables.hidden_from[k],
            panels[k],
            finest,
            nodes.place[k],
            nodes.weight[k],
            nodes.tail[k],
        )
        # Frictions that the speeds rule out lie beyond the fine ones.
        if track.grid[0] > mu[0]:
            nodes.tail[k, 0] = 0.0
        if track.grid[-1] < mu[-1]:
            nodes.tail[k, 1] = 0.0


@kernel
def between(  # type: ignore[no-untyped-def]
    mu, record, left, speeds, cell, jumped, log_likelihood, observed_left
):
    """Tables of one event `[n_friction(, n_speeds)]` over finer frictions about the likely ones.

    `log_likelihood` `[n_friction - 1]` bounds what each cell of the grid `mu` can hold. Where the
    block stops short of a place in the next friction, its u² is carried on from the cell before;
    in the `cell` over which F jumps, u² is `jumped` `[n_speeds]`.
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
                    square[row, a] = jumped[a]
                else:
                    square[row, a] = max(speeds[j, a] ** 2 + share * rise[a], 0.0)
    grid[n - 1], fine_record[n - 1], fine_left[n - 1] = mu[last], record[last], left[last]
    square[n - 1] = speeds[last] ** 2
    if last == cell:
        square[n - 1] = jumped
    return FineTrack(grid, fine_record, fine_left, square)
