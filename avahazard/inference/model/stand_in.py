"""What a column that goes with the volume, as a deposit's length does, tells of true volumes."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats


def told_by_stand_in(log_volume: Floats, stand_in: Floats, path: tuple[str, ...]) -> Floats:
    """Log true volume over its path's mean, as `stand_in` tells it, all `[n_events]`; nan if not.

    By the line of least squares through what events have of both, less the means of their paths.
    Errors of recorded volumes do not bend it: they scatter about it.
    """
    names = np.array(path)
    both = np.isfinite(log_volume) & np.isfinite(stand_in)
    away = np.full((2, len(names)), np.nan)
    for name in set(path):
        mine = names == name
        if np.sum(both & mine) > 1:
            for row, values in zip(away, (stand_in, log_volume), strict=True):
                row[mine] = values[mine] - np.mean(values[both & mine])
    known = np.isfinite(away).all(axis=0)
    squares = float(np.sum(away[0, known] ** 2))
    if squares == 0.0:
        return np.full(len(names), np.nan)
    return np.asarray(away[0] * (float(away[0, known] @ away[1, known]) / squares))
