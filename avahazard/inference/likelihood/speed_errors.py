"""Errors of the speeds of one track: the measurement's, and the model's own.

Those of the measurement at the places x are independent; the model's, with standard deviation
`scatter`, are alike over `SPEED_CORRELATION_M`: their covariance is scatter² exp(-|Δx| / length).
"""

from __future__ import annotations

import numpy as np

from avahazard.kernels import kernel

SPEED_CORRELATION_M = 100.0
"""Length over which the model's error of speed stays alike: about that of a terrain step."""


@kernel
def covariance_root(x, sigma, scatter):  # type: ignore[no-untyped-def]
    """Lower Cholesky factor of the covariance (m²/s²), `[n_speeds, n_speeds]`.

    `x` (m), `sigma` (m/s) `[n_speeds]` are places and errors of the measurement; `scatter` in m/s.
    """
    k = len(x)
    covariance = np.empty((k, k))
    for a in range(k):
        for b in range(k):
            alike = np.exp(-abs(x[a] - x[b]) / SPEED_CORRELATION_M)
            covariance[a, b] = scatter * scatter * alike
        covariance[a, a] += sigma[a] ** 2
    return np.linalg.cholesky(covariance)


@kernel
def whitening(x, sigma, scatter):  # type: ignore[no-untyped-def]
    """What makes misfits `[n_speeds]` independent unit errors, as a matrix, and a constant.

    The log density is less than nought by half the sum of their squares and the constant.
    """
    whiten = np.linalg.inv(covariance_root(x, sigma, scatter))
    constant = 0.5 * len(x) * np.log(2.0 * np.pi)
    for a in range(len(x)):
        constant -= np.log(whiten[a, a])
    return whiten, constant
