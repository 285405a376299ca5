"""Errors of the speeds of one track: the measurement's, and those of a friction that is uneven.

They are told of squares of speed, since work adds up to these: u² is that of the block plus r
(`model.speed_record`) with standard deviations in proportion to `scatter`, that of friction along
the track. A measured speed u + e of error σ gives u² by (u + e)² - σ², with variance
4 u² σ² + 2 σ⁴. The u in it is the mean of the measured speed and those beside it: by its own error
alone, what was measured too low would weigh too much.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.observations import SpeedRecord
from avahazard.kernels import kernel

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
    log density of the speeds (not of their squares) is less than nought by half the sum of the
    squares of these and the constant. `spread` as in `SpeedRecord`.
    """
    square, error = squared(speed, sigma)
    k = len(speed)
    covariance = np.empty((k, k))
    for a in range(k):
        for b in range(k):
            covariance[a, b] = scatter * scatter * spread[a, b]
        covariance[a, a] += error[a] * error[a]
    whiten = inverse_root(covariance)
    constant = 0.5 * k * np.log(2.0 * np.pi)
    for a in range(k):
        constant -= np.log(whiten[a, a] * error[a] / sigma[a])
    return square, whiten, constant


@kernel
def speed_log_density(predicted, errors):  # type: ignore[no-untyped-def]
    """Log density of one track's speeds for each row of u² `predicted` `[n_friction, n_speeds]`."""
    measured, whiten, constant = errors
    k = len(measured)
    result = np.empty(len(predicted))
    misfit = np.empty(k)
    for j in range(len(predicted)):
        total = 0.0
        for a in range(k):
            misfit[a] = measured[a] - predicted[j, a]
            z = 0.0
            for b in range(a + 1):
                z += whiten[a, b] * misfit[b]
            total += z * z
        result[j] = -0.5 * total - constant
    return result


@kernel
def inverse_root(covariance):  # type: ignore[no-untyped-def]
    """Inverse of the lower Cholesky factor `[n, n]`: of so few speeds quicker than by a library."""
    n = len(covariance)
    root, inverse = np.zeros((n, n)), np.zeros((n, n))
    for a in range(n):
        for b in range(a + 1):
            rest = covariance[a, b]
            for c in range(b):
                rest -= root[a, c] * root[b, c]
            root[a, b] = np.sqrt(rest) if a == b else rest / root[b, b]
    for b in range(n):
        inverse[b, b] = 1.0 / root[b, b]
        for a in range(b + 1, n):
            total = 0.0
            for c in range(b, a):
                total += root[a, c] * inverse[c, b]
            inverse[a, b] = -total / root[a, a]
    return inverse


def drawn_speeds(
    square: Floats, track: SpeedRecord, scatter: float, rng: np.random.Generator, arrives: bool
) -> Floats:
    """Measured speeds (m/s) of avalanches whose block has these squares `[n_speeds, n_draws]`.

    What came as far as a place was moving there. So where the block moves (everywhere, for one that
    is known to arrive at its stop), r is drawn again until the avalanche moves; if it does so in
    none of `MAX_REDRAWS`, the least impossible one counts.
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
