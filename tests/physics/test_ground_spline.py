from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_smoothing_spline

from avahazard.physics.ground_spline import GroundPosterior, block_length, ground_posterior

X = np.linspace(0.0, 1000.0, 81)


def posterior(y: np.ndarray, sigma: float = 1.0, penalty: float = 1e4, block_m: float = 100.0):
    return ground_posterior(X, y, np.full(len(X), sigma), penalty, block_m)


def dense(bands: np.ndarray) -> np.ndarray:
    """The symmetric matrix of upper bands."""
    n = bands.shape[1]
    full = np.zeros((n, n))
    for k in range(4):
        for i in range(n - k):
            full[i, i + k] = full[i + k, i] = bands[3 - k, i + k]
    return full


def unfelt(found: GroundPosterior) -> BSpline:
    """The fit to the points, before the block's length."""
    return BSpline(found.knots, found.mean, 3)


def test_the_fit_is_the_smoothing_spline() -> None:
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0.0, 1000.0, 60))
    y = 500.0 - 0.4 * x + rng.normal(0.0, 3.0, 60)
    sigma = rng.uniform(1.0, 4.0, 60)
    found = unfelt(ground_posterior(x, y, sigma, 2e5, 40.0))
    exact = make_smoothing_spline(x, y, sigma**-2, lam=2e5)
    at = np.linspace(x[0], x[-1], 300)
    np.testing.assert_allclose(found(at), exact(at), atol=0.02)


def test_matrices_are_the_integrals() -> None:
    found = posterior(X)
    n = len(found.mean)
    fine = np.linspace(X[0], X[-1], 40_001)
    basis = np.array([BSpline(found.knots, row, 3)(fine) for row in np.eye(n)])
    gram = basis @ basis.T * (fine[1] - fine[0])
    np.testing.assert_allclose(dense(found.gram), gram, atol=1e-2)


@pytest.mark.parametrize(("wavelength", "kept"), [(400.0, 256 / 257), (100.0, 0.5), (50.0, 1 / 17)])
def test_a_block_feels_no_bumps_much_shorter_than_itself(wavelength: float, kept: float) -> None:
    wave = np.sin(2.0 * np.pi * X / wavelength)
    f = ground_posterior(X, wave, np.full(len(X), 1e-3), 1e-3, 100.0).ground()
    middle = np.linspace(300.0, 700.0, 801)
    assert np.ptp(f(middle)) / 2.0 == pytest.approx(kept, abs=0.02)


def test_what_is_felt_does_not_hang_on_how_close_the_points_are() -> None:
    def felt(n: int):
        x = np.linspace(0.0, 1000.0, n)
        y = 600.0 - 0.5 * x + 3.0 * np.sin(2.0 * np.pi * x / 80.0)
        return ground_posterior(x, y, np.full(n, 1e-3), 1e-3, 100.0).ground()

    at = np.linspace(150.0, 850.0, 500)
    np.testing.assert_allclose(felt(101)(at), felt(1001)(at), atol=0.05)


def test_the_spread_is_that_of_the_normal_distribution() -> None:
    found = posterior(X, sigma=2.0)
    n = len(found.mean)
    at = np.linspace(0.0, 1000.0, 30)
    rows = np.array([BSpline(found.knots, row, 3)(at) for row in np.eye(n)]).T
    upper = np.triu(np.array([[found.factor[3 - (j - i), j] if 0 <= j - i < 4 else 0.0
                               for j in range(n)] for i in range(n)]))  # fmt: skip
    covariance = np.linalg.inv(upper.T @ upper)
    feel = np.array([found._felt(row).c for row in np.eye(n)]).T
    variance = np.einsum("ij,jk,ik->i", rows @ feel, covariance, rows @ feel)
    np.testing.assert_allclose(found.sd(at), np.sqrt(variance), rtol=1e-6)


def test_noise_lies_within_its_band() -> None:
    """Ground that is an integrated Wiener process: 90 % of it within 1.645 sd, felt as it is."""
    rng = np.random.default_rng(7)
    step, tau, sigma = X[1] - X[0], 2e-4, 3.0
    inside = []
    for _ in range(60):
        bend = rng.normal(0.0, tau / np.sqrt(step / 10), 10 * len(X))
        fine = np.cumsum(np.cumsum(bend) * step / 10) * step / 10
        y = fine[::10][: len(X)]
        found = posterior(y + rng.normal(0.0, sigma, len(X)), sigma, tau**-2, 20.0)
        off = (found.ground()(X) - y) / found.sd(X)
        inside.append(np.mean(np.abs(off) < 1.645))
    assert np.mean(inside) == pytest.approx(0.9, abs=0.04)


def test_the_block_is_shorter_on_short_paths() -> None:
    assert block_length(3000.0) == 100.0
    assert block_length(350.0) == pytest.approx(35.0)


def test_a_long_path_with_many_points_stays_a_band() -> None:
    x = np.linspace(0.0, 60_000.0, 20_001)
    found = ground_posterior(x, 3000.0 - 0.05 * x, np.ones(len(x)), 1e6, 100.0)
    assert found.factor.shape == (4, len(found.mean)) == (4, 3003)
    np.testing.assert_allclose(found.ground()(x), 3000.0 - 0.05 * x, atol=1e-4)
