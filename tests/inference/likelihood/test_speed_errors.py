"""The errors of speeds against their covariance written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.speed_errors import (
    SPEED_CORRELATION_M,
    covariance_root,
    whitening,
)

X = np.array([0.0, 30.0, 200.0, 210.0])
SIGMA = np.array([1.0, 0.5, 2.0, 1.5])
SCATTER = 3.0


def covariance() -> np.ndarray:
    result = np.diag(SIGMA**2)
    for a, x in enumerate(X):
        for b, y in enumerate(X):
            result[a, b] += SCATTER**2 * np.exp(-abs(x - y) / SPEED_CORRELATION_M)
    return result


def test_the_root_squared_is_the_covariance() -> None:
    root = covariance_root(X, SIGMA, SCATTER)
    np.testing.assert_array_equal(root, np.tril(root))
    np.testing.assert_allclose(root @ root.T, covariance(), rtol=1e-12)


def test_whitened_misfits_give_the_density() -> None:
    whiten, constant = whitening(X, SIGMA, SCATTER)
    misfit = np.array([0.3, -2.0, 1.0, 4.0])
    log_density = -0.5 * np.sum((whiten @ misfit) ** 2) - constant
    expected = stats.multivariate_normal(np.zeros(4), covariance()).logpdf(misfit)
    assert log_density == pytest.approx(expected, rel=1e-12)
