"""Apparent friction: the μ whose block stops where the record says (the inverse of F).

On stepped terrain F jumps and has no inverse there. That is said in the status, and no other part
of the product infers from these values except the paper's own methods, which are built on them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.kernels import kernel
from avahazard.physics.block import STOPPED
from avahazard.physics.runout_curve import RunoutCurve

Array = NDArray[np.float64]

STATUSES = (
    "unique",  # one friction stops there
    "jump",  # no friction does: F jumps over the record; μ is where it jumps
    "several",  # more than one does; μ is the middle of the outermost
    "above",  # every block goes lower: friction above the table, or a record above the release
    "below",  # no block stops so low: μ is at most mu_high
    "no-record",
)
UNIQUE, JUMP, SEVERAL, ABOVE, BELOW, NO_RECORD = range(6)


@dataclass(frozen=True, slots=True)
class ApparentFriction:
    """Per event [n_events]: μ, the bracket that F gives, and a code that `STATUSES` names.

    μ is nan for "above" and "below", where only one side of the bracket is finite, and for
    "no-record".
    """

    mu: Array
    mu_low: Array
    mu_high: Array
    status: NDArray[np.int64]

    def labels(self) -> list[str]:
        """The status in words, one per event."""
        return [STATUSES[code] for code in self.status]


def apparent_friction(
    runout: Array,
    table: NDArray[np.int64],
    stop_y: Array,
    curves: RunoutCurve,
) -> ApparentFriction:
    """Inverts the curves [n_tables, n_mu] at the recorded elevations `runout` [n_events], m.

    `stop_y` [n_tables, n_mu] is where they stop, in the coordinate of the records and rising, and
    `table` [n_events] the row of each event. Only stops bracket a record; jumps are those of
    `runout_curve`. The record of an event that left the profile is -inf.
    """
    runout = np.asarray(runout, np.float64)
    mu, mu_low, mu_high = np.full((3, runout.size), np.nan)
    status = np.full(runout.size, NO_RECORD)
    for k in np.unique(table):
        stopped, broken = curves.status[k] == STOPPED, curves[k].broken
        for i in np.flatnonzero(np.asarray(table) == k):
            low, high, code = bracket(runout[i], stop_y[k], stopped, broken, curves.mu)
            mu_low[i], mu_high[i], status[i] = low, high, code
            if code <= SEVERAL:
                mu[i] = 0.5 * (low + high)
    return ApparentFriction(mu, mu_low, mu_high, status)


@kernel
def bracket(
    y: float,
    stop_y: Array,
    stopped: NDArray[np.bool_],
    broken: NDArray[np.bool_],
    mu: Array,
) -> tuple[float, float, int]:
    """Smallest and largest μ whose block stops at y, m, and the status code, of one table.

    `stopped`, `mu` [n_mu]; `broken` [n_mu - 1] are the cells of jumps.
    """
    if np.isnan(y):
        return np.nan, np.nan, NO_RECORD
    low, high, crossings, jumped = np.inf, -np.inf, 0, False
    least, first, last = np.inf, -1, -1
    for j in range(stop_y.size):
        if not stopped[j]:
            continue
        above = stop_y[j]
        least = min(least, above)
        if first < 0:
            first = j
        # half-open, so that a record on a grid value counts once
        elif (
            stop_y[last] < y <= above
            or above <= y < stop_y[last]
            or (last == first and y == stop_y[first])
        ):
            below = stop_y[last]
            left, right = mu[last], mu[j]
            crossings += 1
            if j > last + 1 or broken[last]:
                jumped = True
            elif above != below:
                left = right = left + (right - left) * (y - below) / (above - below)
            low, high = min(low, left), max(high, right)
        last = j
    if crossings > 1:
        return low, high, SEVERAL
    if crossings == 1:
        return low, high, JUMP if jumped else UNIQUE
    if first < 0:
        return -np.inf, np.inf, BELOW
    if y <= least:
        return -np.inf, mu[first], BELOW
    return mu[last], np.inf, ABOVE
