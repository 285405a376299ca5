"""What a column that goes with the volume, as a deposit's length does, tells of true volumes."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats, Ints


def told_by_stand_in(log_volume: Floats, stand_in: Floats, path: Ints) -> Floats:
    """Log true volume over its path's mean, as `stand_in` tells it, all `[n_events]`; nan if not.

    `path` `[n_events]` is a number for each.

    By the line of least squares through what events have of both, less the means of their paths.
    Errors of recorded volumes do not bend it: they scatter about it.
    """
    away = within_paths(np.array([stand_in, log_volume]), path)
    known = np.isfinite(away).all(axis=0)
    squares = float(np.sum(away[0, known] ** 2))
    if squares == 0.0:
        return np.full(len(path), np.nan)
    return np.asarray(away[0] * (float(away[0, known] @ away[1, known]) / squares))


def within_paths(pair: Floats, path: Ints) -> Floats:
    """Both rows `[2, n_events]` less their means over the events of a `path` that have both.

    nan where it is missing, and on paths with fewer than two such events.
    """
    both = np.isfinite(pair).all(axis=0)
    away = np.full(pair.shape, np.nan)
    for k in np.unique(path):
        mine = path == k
        if np.sum(both & mine) > 1:
            away[:, mine] = pair[:, mine] - pair[:, both & mine].mean(axis=1, keepdims=True)
    return away
