"""F(μ) near some stops alone, and with what it takes to know that no other friction comes there.

At any place a block with less friction is faster, so F falls with friction: runs go from a first
guess to both sides until they are past the stops that are asked for. What would be beyond is not
run, but held at the last that was.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.kernels import kernel
from avahazard.physics.batch import march, new_batch, release
from avahazard.physics.block import LEFT_PROFILE, NOT_RELEASED, STOPPED
from avahazard.physics.cell_motion import elevation_in_cell
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import RunoutCurve

MARGIN, SLOW_MARGIN = 12, 3
"""Frictions beyond the stops asked for: what is a jump shows by the cells beside it, and the
screening reads speeds at every fourth friction. The second where resistance depends on speed, whose
frictions lie four times as far apart (`effects.site`)."""
WIDTH, SLOW_WIDTH = 32, 16
"""Frictions run at once; the second where resistance depends on speed, and each costs by itself."""


class Asked(NamedTuple):
    """Stops asked for from each start, `[n_starts]`.

    Those between the places `low` and `high` (m); where `high` is inf all that leaves the profile
    is asked for as well. Runs begin about the friction with index `middle`.
    """

    low: Floats
    high: Floats
    middle: Ints


class NearStops(NamedTuple):
    """`curve` `[n_starts, n_friction]`, run from index `first` up to before `end` `[n_starts]`.

    Below and above these its end is repeated.
    """

    curve: RunoutCurve
    first: Ints
    end: Ints


def near_stops(cells: Cells, starts: NDArray[np.int64], mu: Floats, asked: Asked) -> NearStops:
    """F(μ) from each start node `[n_starts]` near what is asked, the same for every `middle`.

    `mu` `[n_friction]` rise.
    """
    mu = np.ascontiguousarray(mu, np.float64)
    slow = cells.speed_dependent
    width, margin = (SLOW_WIDTH, SLOW_MARGIN) if slow else (WIDTH, MARGIN)
    x, y, status, first, end = _near(cells, starts, mu, *asked, width, margin)
    return NearStops(RunoutCurve(x, y, status, mu), first, end)


@kernel
def _near(cells, starts, mu, low, high, middle, width, margin):  # type: ignore[no-untyped-def]
    n_starts, n = len(starts), len(mu)
    x, y = np.empty((n_starts, n)), np.empty((n_starts, n))
    status = np.empty((n_starts, n), dtype=np.int8)
    firsts, ends = np.empty(n_starts, dtype=np.int64), np.empty(n_starts, dtype=np.int64)
    batch = new_batch(2, 1)
    for s in range(n_starts):
        first = max(0, min(middle[s] - width // 2, n - width))
        end = min(first + width, n)
        _run(cells, starts[s], mu, first, end, batch, x[s], y[s], status[s])
        while first > 0 and not _beyond(x[s], status[s], first + margin, high[s]):
            more = max(0, first - width)
            _run(cells, starts[s], mu, more, first, batch, x[s], y[s], status[s])
            first = more
        while end < n and not x[s, end - 1 - margin] < low[s]:
            more = min(n, end + width)
            _run(cells, starts[s], mu, end, more, batch, x[s], y[s], status[s])
            end = more
        # As if no more had been run than is needed, wherever it began.
        above, below = first, end - 1
        while above + 1 < end and _beyond(x[s], status[s], above + 1, high[s]):
            above += 1
        while below - 1 >= first and x[s, below - 1] < low[s]:
            below -= 1
        first, end = max(above - margin, first), min(below + 1 + margin, end)
        firsts[s], ends[s] = first, end
        x[s, :first], y[s, :first], status[s, :first] = x[s, first], y[s, first], status[s, first]
        x[s, end:], y[s, end:] = x[s, end - 1], y[s, end - 1]
        status[s, end:] = status[s, end - 1]
    return x, y, status, firsts, ends


@kernel
def _beyond(x, status, j, high):  # type: ignore[no-untyped-def]
    """Whether friction j brings the block past all that is asked for."""
    return np.isfinite(high) if status[j] == LEFT_PROFILE else x[j] > high


@kernel
def _run(cells, start, mu, first, end, batch, x, y, status):  # type: ignore[no-untyped-def]
    """Fill in where blocks with frictions from `first` up to before `end` stop."""
    n = end - first
    n_moving = release(cells, start, mu[first:end], 0, batch)
    for j in range(n):
        moves = not np.isnan(batch.w[start & 1, j])
        x[first + j], y[first + j] = np.nan, np.nan
        status[first + j] = LEFT_PROFILE if moves else NOT_RELEASED
        if not moves:
            x[first + j], y[first + j] = cells.x[start], cells.y[start]
    march(cells, start, batch, n_moving)
    for j in range(n):
        i = batch.stop_cell[j]
        if i >= 0:
            t = batch.stop_t[j]
            status[first + j] = STOPPED
            x[first + j] = cells.x[i] + t * (cells.x[i + 1] - cells.x[i])
            y[first + j] = elevation_in_cell(cells, i, t)
