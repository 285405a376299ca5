"""Regularised paths: the spline, its error, and how near a polynomial comes to the points."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Legendre
from scipy.interpolate import BSpline, make_smoothing_spline

from avahazard.physics.smooth_profile import (
    FINEST_M,
    GroundPosterior,
    block_length,
    ground_posterior,
    legendre_profile,
    smooth_profile,
)
from tests.physics import naive
from tests.physics.paths import drawn_profile, read_profiles, spline_profile

EVEN = np.linspace(0.0, 1000.0, 81)


def posterior(y: np.ndarray, sigma: float = 1.0, penalty: float = 1e4, block_m: float = 100.0):
    return ground_posterior(EVEN, y, np.full(len(EVEN), sigma), penalty, block_m)


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
    found = posterior(EVEN)
    n = len(found.mean)
    fine = np.linspace(EVEN[0], EVEN[-1], 40_001)
    basis = np.array([BSpline(found.knots, row, 3)(fine) for row in np.eye(n)])
    gram = basis @ basis.T * (fine[1] - fine[0])
    np.testing.assert_allclose(dense(found.gram), gram, atol=1e-2)


@pytest.mark.parametrize(("wavelength", "kept"), [(400.0, 256 / 257), (100.0, 0.5), (50.0, 1 / 17)])
def test_a_block_feels_no_bumps_much_shorter_than_itself(wavelength: float, kept: float) -> None:
    wave = np.sin(2.0 * np.pi * EVEN / wavelength)
    f = ground_posterior(EVEN, wave, np.full(len(EVEN), 1e-3), 1e-3, 100.0).ground()
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
    found = posterior(EVEN, sigma=2.0)
    n = len(found.mean)
    at = np.linspace(0.0, 1000.0, 30)
    rows = np.array([BSpline(found.knots, row, 3)(at) for row in np.eye(n)]).T
    upper = np.triu(np.array([[found.factor[3 - (j - i), j] if 0 <= j - i < 4 else 0.0
                               for j in range(n)] for i in range(n)]))  # fmt: skip
    covariance = np.linalg.inv(upper.T @ upper)
    feel = np.array([replace(found, mean=row).ground().c for row in np.eye(n)]).T
    variance = np.einsum("ij,jk,ik->i", rows @ feel, covariance, rows @ feel)
    np.testing.assert_allclose(found.sd(at), np.sqrt(variance), rtol=1e-6)


def test_noise_lies_within_its_band() -> None:
    """Ground that is an integrated Wiener process: 90 % of it within 1.645 sd, felt as it is."""
    rng = np.random.default_rng(7)
    step, tau, sigma = EVEN[1] - EVEN[0], 2e-4, 3.0
    inside = []
    for _ in range(60):
        bend = rng.normal(0.0, tau / np.sqrt(step / 10), 10 * len(EVEN))
        fine = np.cumsum(np.cumsum(bend) * step / 10) * step / 10
        y = fine[::10][: len(EVEN)]
        found = posterior(y + rng.normal(0.0, sigma, len(EVEN)), sigma, tau**-2, 20.0)
        off = (found.ground()(EVEN) - y) / found.sd(EVEN)
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


X = np.sort(np.random.default_rng(5).uniform(0.0, 3000.0, 90))


def bumpy(size: float) -> np.ndarray:
    return 2000.0 - 0.4 * X + size * np.sin(X / 70.0)


@pytest.mark.parametrize("penalty", [1e-6, 1e-4, 1e-1])
@pytest.mark.parametrize("degree", [3, 8])
def test_legendre_solves_the_normal_equations(degree: int, penalty: float) -> None:
    y = bumpy(30.0)
    coefficients, basis = naive.legendre_coefficients(X, y, degree, penalty)
    fitted = legendre_profile(X, y, degree, penalty)
    np.testing.assert_allclose(fitted.height(X), basis @ coefficients, atol=1e-7)


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-300.0, 300.0), min_size=1, max_size=9))
def test_polynomials_up_to_degree_8_come_back(coefficients: list[float]) -> None:
    f = Legendre(coefficients, domain=[X[0], X[-1]])
    fitted = legendre_profile(X, f(X), penalty=1e-13)
    assert fitted.max_deviation_m < 1e-4
    at = np.linspace(X[0], X[-1], 50)
    for value, exact in zip(fitted.derivatives(at), (f, f.deriv(), f.deriv(2)), strict=True):
        np.testing.assert_allclose(value, exact(at), atol=1e-4)


def test_a_cubic_through_four_points_and_no_error_of_a_bare_polynomial() -> None:
    x = X[[0, 20, 50, 89]]
    f = Legendre([1500.0, -500.0, 60.0, -10.0], domain=[X[0], X[-1]])
    fitted = legendre_profile(x, f(x), penalty=1e-13)
    assert fitted.degree == 3
    np.testing.assert_allclose(fitted.height(X), f(X), atol=1e-4)
    assert (fitted.sigma_m, fitted.sigma_source, fitted.posterior) == (0.0, None, None)


@pytest.mark.parametrize(("sigma", "method"), [(1.001, "legendre"), (0.999, "spline")])
def test_auto_turns_to_the_spline_where_the_polynomial_misses_by_more_than_the_error(
    sigma: float, method: str
) -> None:
    y = bumpy(30.0)
    given = np.full(len(X), sigma * legendre_profile(X, y).rms_m)
    fitted = smooth_profile(X, y, given)
    assert fitted.method == method
    assert fitted.sigma_m == pytest.approx(given[0])
    assert fitted.sigma_source == "given"


def test_a_polynomial_with_errors_is_taken_for_one() -> None:
    f = Legendre([1500.0, -500.0, 60.0, -10.0, 5.0], domain=[X[0], X[-1]])
    y = f(X) + np.random.default_rng(2).normal(0.0, 3.0, len(X))
    fitted = smooth_profile(X, y)
    assert fitted.method == "legendre"
    assert fitted.rms_m <= fitted.sigma_m == pytest.approx(3.0, rel=0.25)
    assert fitted.posterior is not None


def test_the_misfit_of_noisy_points_is_their_error_and_not_its_largest_value() -> None:
    rng = np.random.default_rng(3)
    y = bumpy(8.0) + rng.normal(0.0, 5.0, len(X))
    fitted = smooth_profile(X, y)
    assert fitted.method == "spline"
    assert fitted.rms_m == pytest.approx(fitted.sigma_m, rel=0.15)
    assert fitted.max_deviation_m > 2.0 * fitted.sigma_m


def test_errors_of_one_profile_may_differ() -> None:
    rng = np.random.default_rng(4)
    x = np.linspace(0.0, 2000.0, 201)
    truth = 1500.0 - 0.5 * x + 6.0 * np.sin(x / 90.0)
    sigma = np.where(x < 1000.0, 0.2, 6.0)
    fitted = smooth_profile(x, truth + sigma * rng.standard_normal(201), sigma)
    off = np.abs(fitted.height(x) - truth)
    assert off[x < 900.0].max() < 0.6
    assert off[x > 1000.0].max() < 8.0
    # Weighted by 1/σ², the good points speak.
    assert fitted.sigma_m == pytest.approx(0.2 * np.sqrt(2.0), rel=0.02)
    assert fitted.rms_m < 0.5


@pytest.mark.parametrize("fit", [legendre_profile, spline_profile])
def test_derivatives_agree_with_differences(fit) -> None:
    fitted = fit(X, bumpy(15.0))
    at, h = np.linspace(X[0] + 1.0, X[-1] - 1.0, 200), 0.05
    before, here, after = (fitted.derivatives(at + s * h) for s in (-1, 0, 1))
    np.testing.assert_allclose(here[1], (after[0] - before[0]) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(here[2], (after[1] - before[1]) / (2 * h), atol=1e-4)


@pytest.mark.parametrize("n", [2, 3, 5, 40])
def test_a_straight_slope_stays_straight(n: int) -> None:
    x, y = np.linspace(0.0, 900.0, n), np.linspace(800.0, 350.0, n)
    fitted = smooth_profile(x, y)
    np.testing.assert_allclose(fitted.height([150.0, 450.0]), [725.0, 575.0], atol=1e-3)


def test_few_points_pass_through_and_are_told_to_be_few() -> None:
    x = np.array([0.0, 200.0, 400.0, 700.0, 1000.0, 1400.0, 2000.0])
    y = np.array([2000.0, 1850.0, 1710.0, 1530.0, 1390.0, 1270.0, 1218.0])
    fitted = smooth_profile(x, y)
    assert fitted.method == "spline"
    assert fitted.sigma_source == "assumed"
    assert fitted.sigma_m == pytest.approx(FINEST_M)
    assert fitted.max_deviation_m < 0.5
    assert np.all(fitted.derivatives(np.linspace(0.0, 2000.0, 400))[1] < 0.0)


def test_surveyed_ground_keeps_its_shape(shared_data) -> None:
    for x, y in read_profiles(shared_data / "tyrol-profiles" / "profiles.csv").values():
        fitted = smooth_profile(x, y)
        assert fitted.method == "spline"
        assert fitted.sigma_m < 1.5
        assert fitted.rms_m < 2.0


def test_draws_and_their_spread_are_those_of_the_posterior() -> None:
    rng = np.random.default_rng(6)
    x = np.arange(0.0, 2000.0, 20.0)
    fitted = spline_profile(x, 1000.0 - 0.4 * x + rng.normal(0.0, 3.0, len(x)), 3.0)
    assert fitted.posterior is not None
    at = np.linspace(0.0, 1980.0, 40)
    draws = np.array([drawn_profile(fitted, rng).height(at) for _ in range(600)])
    np.testing.assert_allclose(draws.std(axis=0), fitted.posterior.sd(at), rtol=0.15)
    off = (draws.mean(axis=0) - fitted.height(at)) / fitted.posterior.sd(at)
    assert np.abs(off).max() < 0.2


def test_a_profile_can_be_sent_to_another_process() -> None:
    fitted = smooth_profile(X, bumpy(15.0))
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.height(X), fitted.height(X))
