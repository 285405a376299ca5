"""The most that each cell of frictions can hold of a record with speeds, without its nodes.

Nodes are then made where it counts alone.
"""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.record_density import DEPTH, REACH
from avahazard.inference.likelihood.speed_errors import speed_log_density
from avahazard.kernels import kernel

BESIDE = 4
"""Rows kept beyond the frictions that a record leaves: two go to the fine frictions beside it."""


@kernel
def rows_left(record, left, observed_left, observed, error):  # type: ignore[no-untyped-def]
    """First row and end `[n_tracks, 2]` of the frictions `[n_tracks, n_friction]` that count.

    They are those whose cells `cell_bounds` may ask for, and `BESIDE` more.
    """
    rows = np.empty((len(record), 2), dtype=np.int64)
    for k in range(len(record)):
        bound = _by_record(record[k], left[k], observed_left[k], observed[k], error[k])
        within = np.flatnonzero(bound >= min(np.max(bound), -0.5 * REACH * REACH))
        rows[k, 0] = max(within[0] - BESIDE, 0)
        rows[k, 1] = min(within[-1] + 2 + BESIDE, record.shape[1])
    return rows


@kernel
def cell_bounds(  # type: ignore[no-untyped-def]
    predicted, cell, jumped, errors, record, left, observed_left, observed, error
):
    """The most that the log likelihood can be in each cell of frictions `[n_friction - 1]`.

    -inf where the record is out of reach, and where it leaves less than `DEPTH` below the best:
    speeds can add no more than their density at its highest.
    """
    bound = _by_record(record, left, observed_left, observed, error)
    best = np.argmax(bound)
    ends = _at_ends(np.array([best]), predicted, cell, jumped, errors)
    least = bound[best] + max(ends[best], ends[best + 1]) - DEPTH + errors[2]
    # Beyond reach there are no points of the likelihood: the nearest friction, at most.
    likely = np.flatnonzero(bound >= max(least, min(bound[best], -0.5 * REACH * REACH)))
    ends = _at_ends(likely, predicted, cell, jumped, errors)
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
def _at_ends(cells, predicted, cell, jumped, errors):  # type: ignore[no-untyped-def]
    """Log density of the speeds at the ends of these cells, `[n_friction]`; -inf elsewhere.

    In `cell` the block that passes comes as slow as `jumped`; so does all between it and the next.
    """
    asked = np.zeros(len(predicted), dtype=np.bool_)
    for j in cells:
        asked[j], asked[j + 1] = True, True
    rows = np.flatnonzero(asked)
    square = predicted[rows] ** 2
    for k in range(len(rows)):
        if rows[k] == cell:
            square[k] = jumped
    result = np.full(len(predicted), -np.inf)
    result[rows] = speed_log_density(square, errors)
    return result
