"""How far a friction law's predicted stops lie from the records: the sum of squares, compiled.

The whole cost of a Metropolis chain is here. Friction tables lie on a uniform grid, so F(μ) is one
multiplication and one interpolation, and nothing in the loop branches. It is straight across a jump
as elsewhere: as in `likelihood.record_density`, what a record tells of friction has no gaps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.laws import Law
from avahazard.kernels import kernel
from avahazard.records.errors import AvahazardError

FAST_BUT_NAN = {"reassoc", "contract", "nsz", "arcp"}  # all but nnan and ninf


class FitRecords(NamedTuple):
    """FitRecords and the tables that predict them, as the compiled loop wants them.

    `x` [n_events] is what log μ is linear in; `y` [n_events] the recorded stop, m; `offset`
    [n_events] where an event's table begins in `stops`, all tables one after the other. Without
    tables, y itself is linear in x: an ordinary regression. `bends`: the rational law.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    offset: NDArray[np.int64]
    stops: NDArray[np.float64]
    mu_min: float
    mu_step: float
    n_mu: int
    bends: bool


def runout_records(
    law: Law,
    volume: NDArray[np.float64],
    runout: NDArray[np.float64],
    table: NDArray[np.int64],
    stop_y: NDArray[np.float64],
    mu_min: float,
    mu_step: float,
) -> FitRecords:
    """FitRecords of runouts [n_events], m, each with its volume, m3, and the row of its table.

    `stop_y` [n_tables, n_mu] holds the elevation of the stop on the grid mu_min + j mu_step, and
    must be finite: the end of the profile where it was left, the release where nothing moved.
    Friction outside of the grid counts as its end. Raises `AvahazardError` on gaps in the data.
    """
    volume, runout = np.asarray(volume, np.float64), np.asarray(runout, np.float64)
    if not np.isfinite(stop_y).all():
        raise AvahazardError("A runout table has gaps.", "Tabulate every friction of the grid.")
    if not (np.isfinite(runout).all() and np.isfinite(volume).all() and (volume > 0).all()):
        raise AvahazardError(
            "An event lacks a runout or a positive volume.",
            "Leave such events out, or use marginal.",
        )
    x = law.covariate(volume)
    stops = np.ascontiguousarray(stop_y, np.float64)
    n_mu = int(stops.shape[1])
    offset = np.asarray(table, np.int64) * n_mu
    bends = law.form == "bend"
    return FitRecords(x, runout, offset, stops.ravel(), float(mu_min), float(mu_step), n_mu, bends)


@kernel(inner=True, fastmath=FAST_BUT_NAN, inline="always")
def _exp(x: float) -> float:
    """e^x for |x| < 36 to 1e-12, without a branch, so that the loop over events runs in vectors."""
    r = min(max(x, -36.0), 36.0) * (1.0 / 256.0)
    p = 1.0 + r * (1 / 5 + r * (1 / 30 + r * (1 / 210 + r * (1 / 1680 + r * (1 / 15120)))))
    p = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 * p))))
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    return p * p


@kernel(fastmath=FAST_BUT_NAN)
def squared_residuals(
    u: NDArray[np.float64], records: FitRecords, place: NDArray[np.float64]
) -> float:
    """Σ (y_i - F(G(V_i; u)))², m2, of the coordinates u [n_coordinates] of a law.

    `place` [n_events] is working memory. Three plain loops, since each then runs in vectors.
    """
    x, y, offset, stops = records.x, records.y, records.offset, records.stops
    slope = u[1] if u.size > 1 else 0.0
    total = 0.0
    if stops.size == 0:
        for i in range(x.size):
            total += (y[i] - u[0] + slope * x[i]) ** 2
        return total
    last_cell = records.n_mu - 2
    start, per_step, last = records.mu_min, 1.0 / records.mu_step, records.n_mu - 1.0
    if records.bends:
        a, n = np.exp(min(u[0], 36.0)), np.exp(min(u[2], 36.0))
        for i in range(x.size):
            mu = a / (1.0 + _exp(n * (x[i] - slope)))
            place[i] = min(max((mu - start) * per_step, 0.0), last)
    else:
        for i in range(x.size):
            mu = _exp(u[0] - slope * x[i])
            place[i] = min(max((mu - start) * per_step, 0.0), last)
    for i in range(x.size):
        cell = min(int(place[i]), last_cell)
        low = stops[offset[i] + cell]
        high = stops[offset[i] + cell + 1]
        total += (y[i] - low - (high - low) * (place[i] - cell)) ** 2
    return total
