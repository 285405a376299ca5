"""Runout of a given volume: draws of friction from P[μ|V], and what they say.

Friction scatters, or the stop by σ metres of elevation about the block's (Ancey 2005, § 2c).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import (
    FrictionGrid,
    piece_at,
)
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.hazard import Spread

Pieces = tuple[Floats, NDArray[np.int8], FrictionGrid]
"""`pieces` of curves `[n_curves, …]`, and the grid of their frictions."""

QUANTILES = (0.05, 0.5, 0.95)
STEPS = tuple(k / 20 for k in range(1, 20))
"""Probabilities 5, 10, … 95 %, at which the distribution of the runout is told."""


@dataclass(frozen=True, slots=True)
class RunoutBounds:
    """What draws of friction make of one volume on one path.

    `n_draws` were drawn. `n_nonpositive` of them had μ ≤ 0, which the normal distribution allows
    and no block can have: they are in none of the other numbers. `p_left_profile` and
    `p_not_released` are shares of the rest; a block that was not released counts as stopped at its
    release. Runs that left the profile are beyond every stop: highest in `x`, lowest in
    `elevation`. `x_steps` are the quantiles of x at `STEPS`, None beyond the profile.
    """

    x: Spread
    elevation: Spread
    p_left_profile: float
    p_not_released: float
    n_draws: int
    n_nonpositive: int
    x_steps: tuple[float | None, ...] = ()


def bounds_of_stops(x: Floats, y: Floats, n_not_released: int, n_draws: int) -> RunoutBounds:
    """Sum up stops (m) `[n_positive]` of `n_draws` draws, those as `draw_stops` gives them."""
    n = len(x)
    left = int(np.count_nonzero(np.isinf(x)))
    return RunoutBounds(
        x=spread(x),
        elevation=spread(y),
        p_left_profile=left / n if n else 0.0,
        p_not_released=n_not_released / n if n else 0.0,
        n_draws=n_draws,
        n_nonpositive=n_draws - n,
        x_steps=tuple(float(q) if np.isfinite(q) else None for q in order_statistics(x, STEPS))
        if n
        else (),
    )


def draw_stops(
    curves: Pieces,
    of: NDArray[np.int64],
    location: Floats,
    scatter: Floats,
    n_draws: int,
    rng: np.random.Generator,
    *,
    in_log: bool,
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Draw frictions over the posterior and run each down the path (Ancey 2005, § 3).

    `location`, `scatter` `[n_posterior]` are of log μ (`in_log`) or μ at the volume in question,
    `of` `[n_posterior]` is the curve of each. Every posterior draw has its equal part of the
    `n_draws` frictions, so the spread holds the natural variability and the uncertainty of the
    parameters.

    Returns stops x and elevation (m) of the draws with μ > 0 `[n_positive]`, (+inf, -inf) where a
    run left the profile, and their number by status `[3]`.
    """
    ends = np.arange(1, len(location) + 1) * n_draws // len(location)
    x, y = np.empty(n_draws), np.empty(n_draws)
    kernel = _lognormal_stops if in_log else _normal_stops
    counts = np.zeros(3, dtype=np.int64)
    n = kernel(rng, *curves, of, location, scatter, ends, x, y, counts)
    return x[:n], y[:n], counts


@kernel
def _lognormal_stops(rng, rows, status, grid, of, location, sd, ends, x, y, counts):  # type: ignore[no-untyped-def]
    i = 0
    for p in range(len(location)):
        row, kind = rows[of[p]], status[of[p]]
        while i < ends[p]:
            mu = np.exp(location[p] + sd[p] * rng.standard_normal())
            k, t = piece_at(row, grid, mu)
            x[i] = row[k, 0] + row[k, 1] * t
            y[i] = row[k, 2] + row[k, 3] * t
            counts[kind[k]] += 1
            i += 1
    return i


@kernel
def _normal_stops(rng, rows, status, grid, of, location, sd, ends, x, y, counts):  # type: ignore[no-untyped-def]
    i = 0
    n = 0
    for p in range(len(location)):
        row, kind = rows[of[p]], status[of[p]]
        while i < ends[p]:
            mu = location[p] + sd[p] * rng.standard_normal()
            i += 1
            if mu > 0.0:
                k, t = piece_at(row, grid, mu)
                x[n] = row[k, 0] + row[k, 1] * t
                y[n] = row[k, 2] + row[k, 3] * t
                counts[kind[k]] += 1
                n += 1
    return n


def spread(values: Floats) -> Spread:
    """Summary of stops `[n]`, infinite where the profile was left."""
    if not len(values):
        return Spread(None, None, None, None)
    quantiles = order_statistics(values, QUANTILES)
    known = np.isfinite(quantiles)
    mean = float(values[np.isfinite(values)].mean()) if known.all() else None
    q05, q50, q95 = (float(q) if ok else None for q, ok in zip(quantiles, known, strict=True))
    return Spread(mean, q05, q50, q95)


def order_statistics(values: Floats, probabilities: Sequence[float]) -> Floats:
    """Quantiles of stops `[n]` that are stops themselves.

    np.quantile mixes neighbours, and inf - inf is nan.
    """
    # Sorting all takes a sixth of `np.partition`: it runs in vectors.
    return np.asarray(np.sort(values)[[ceil(q * len(values)) - 1 for q in probabilities]])


N_PLACES = 4001


def scattered_stops(
    smooth: SmoothProfile,
    release_x: float,
    elevation: Floats,
    sigma: Floats,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, int]:
    """Stops x and elevation (m) at `elevation` + `sigma` z, z ~ N(0, 1), and the number held.

    `elevation` `[n_draws]` of the block's stop is -inf where it left the profile, and stays so;
    `sigma` `[n_draws]` in m. x is the first place of the path that is so low. A stop above the
    release is put there and counted as held; one below the end of the path has left it (+inf,
    -inf); one below a valley floor with a counter-slope behind it lies on the floor.
    """
    x = np.linspace(release_x, smooth.x_max, N_PLACES)
    y = smooth.height(x)
    # The places that are lower than all before them.
    falls = np.concatenate([[True], y[1:] < np.minimum.accumulate(y)[:-1]])
    stop = elevation + sigma * rng.standard_normal(len(elevation))
    held = stop > y[0]
    stop = np.where(held, y[0], stop)
    if not falls[-1]:
        stop = np.where(np.isfinite(elevation), np.maximum(stop, y.min()), stop)
    left = stop < y.min()
    place = np.interp(-stop, -y[falls], x[falls])
    return np.where(left, np.inf, place), np.where(left, -np.inf, stop), int(np.sum(held))
