"""The curves of the laws in their coordinates, for any positive volume, and where to start them.

Coordinates are `[..., n_coordinates]`, volumes `[n_events]` in m3.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

N_SCALE = 1e-6  # 1/m3; n of the exponential law is of this order on paths of 1e4 to 1e6 m3
C_SCALE = 1e5  # m3; the volume where a rational law bends
MOST_LOG = 50.0
"""Log μ of every law is kept within ± this: far beyond what is physical, and no square overflows.

Volumes may be any positive number that a computer knows.
"""

LEAST_SIZE = 1e-100
"""Numbers below are no covariate: a slope over them would overflow."""


def bounded(log_mu: Array) -> Array:
    """Log μ within ± `MOST_LOG`."""
    return np.asarray(np.clip(log_mu, -MOST_LOG, MOST_LOG), np.float64)


def bounded_exp(u: Array) -> Array:
    """exp u, of coordinates that an optimiser may throw far off."""
    return np.asarray(np.exp(np.clip(u, -MOST_LOG, MOST_LOG)), np.float64)


def exponential(u: Array, volume: Array) -> Array:
    """log a - n V."""
    with np.errstate(over="ignore"):  # bounded then
        return bounded(u[..., 0:1] - u[..., 1:2] * in_millions(volume))


def power(u: Array, volume: Array) -> Array:
    """log α - β log V."""
    return bounded(u[..., 0:1] - u[..., 1:2] * np.log(volume))


def rational(u: Array, volume: Array) -> Array:
    """log a/b - log(1 + (V/c)^n / b), with b = 1 in coordinates."""
    bend = bounded_exp(u[..., 2:3]) * (log_in_c(volume) - u[..., 1:2])
    return bounded(u[..., 0:1] - np.logaddexp(0.0, bend))


def asymptotic(u: Array, volume: Array) -> Array:
    """log a + log(e^(-nV) + (1 - e^(-nV)) μ∞/a): a sum of what is positive, so no digits go."""
    reach = bounded_exp(u[..., 2:3] + np.log(volume) + np.log(N_SCALE))
    share = np.exp(-reach) - bounded_exp(u[..., 1:2]) * np.expm1(-reach)
    return bounded(u[..., 0:1] + np.log(share))


def constant(u: Array, volume: Array) -> Array:
    """log a."""
    return bounded(u[..., 0:1] + np.zeros_like(volume))


def columns(*parameters: Array) -> Array:
    """Parameters `[...]` each, side by side `[..., n_parameters]`."""
    result: Array = np.stack(np.broadcast_arrays(*parameters), axis=-1)
    return result


def rational_to_natural(u: Array) -> Array:
    """a, b = 1, c (m3), n."""
    a, c, n = bounded_exp(u[..., 0]), C_SCALE * bounded_exp(u[..., 1]), bounded_exp(u[..., 2])
    return columns(a, np.ones_like(a), c, n)


def rational_from_natural(p: Array) -> Array:
    """Of any b."""
    a, b, c, n = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    return columns(np.log(a / b), np.log(c / C_SCALE) + np.log(b) / n, np.log(n))


def rational_begin(volume: Array, log_mu: Array) -> Array:
    """At the middle volume, then where the power law's slope is half of n."""
    slope = max(line(np.log(volume), log_mu)[1] * -1.0, 0.05)
    level = float(np.median(log_in_c(volume)))
    return np.array([log_mu.mean() + np.log(2.0), level, np.log(2 * slope)])


def asymptotic_to_natural(u: Array) -> Array:
    """a, μ∞, n (1/m3)."""
    a, n = bounded_exp(u[..., 0]), N_SCALE * bounded_exp(u[..., 2])
    return columns(a, a * bounded_exp(u[..., 1]), n)


def asymptotic_from_natural(p: Array) -> Array:
    """Of a, μ∞, n."""
    a, least, n = p[..., 0], p[..., 1], p[..., 2]
    return columns(np.log(a), np.log(least) - np.log(a), np.log(n / N_SCALE))


def asymptotic_begin(volume: Array, log_mu: Array) -> Array:
    """The best line in e^(-nV), over a few n about the reciprocal of the middle volume."""
    middle = float(np.exp(np.median(np.log(volume))))
    best, found = np.inf, np.array([log_mu.mean(), 0.0, 0.0])
    for share in (0.03, 0.1, 0.3, 1.0, 3.0):
        n = np.clip(share / middle / N_SCALE, 1e-4, 1e4)
        fallen = -np.expm1(-n * in_millions(volume))
        log_a, slope = line(fallen, log_mu)
        misfit = float(np.sum((log_mu - log_a - slope * fallen) ** 2))
        if misfit < best:
            best, found = misfit, np.array([log_a, np.clip(slope, -2.0, 2.0), np.log(n)])
    return found


def line_begin(covariate: Callable[[Array], Array]) -> Callable[[Array, Array], Array]:
    """Least squares of a law that is a line in its covariate."""

    def begin(volume: Array, log_mu: Array) -> Array:
        intercept, slope = line(covariate(volume), log_mu)
        return np.array([intercept, -slope])

    return begin


def in_millions(volume: Array) -> Array:
    """V in 1e6 m3."""
    return np.asarray(volume * N_SCALE, np.float64)


def log_in_c(volume: Array) -> Array:
    """log V in 1e5 m3."""
    return np.asarray(np.log(volume) - np.log(C_SCALE), np.float64)


def line(x: Array, y: Array) -> tuple[float, float]:
    """Intercept and slope; x is taken in its own size, so that no square overflows."""
    size = float(np.max(np.abs(x)))
    if size < LEAST_SIZE:
        return float(y.mean()), 0.0
    x = x / size
    centred = x - x.mean()
    spread = float(centred @ centred)
    # Equal x differ by rounding at most.
    slope = float(centred @ y) / spread if spread > 1e-24 * len(x) else 0.0
    return float(y.mean() - slope * x.mean()), slope / size
