"""Regularised paths, and how near a polynomial comes to their points."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Legendre

from avahazard.physics.point_error import FINEST_M
from avahazard.physics.smooth_profile import (
    least_misfit,
    legendre_profile,
    smooth_profile,
    spline_profile,
)
from tests.physics import naive
from tests.physics.paths import drawn_profile, read_profiles

DEGREE = 8


def ground(x: np.ndarray) -> np.ndarray:
    return 900.0 * np.exp(-x / 1200.0) + 5.0 * np.sin(x / 80.0)


def test_it_is_that_of_weighted_least_squares() -> None:
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0.0, 3000.0, 200))
    sigma = rng.uniform(0.1, 3.0, 200)
    y = ground(x) + sigma * rng.standard_normal(200)
    fit = np.polynomial.Polynomial.fit(x, y, DEGREE, w=1.0 / sigma)
    expected = np.mean(((y - fit(x)) / sigma) ** 2)
    assert least_misfit(x, y, sigma, DEGREE) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_no_fit_with_a_penalty_has_less(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 3000.0, 100))
    sigma = rng.uniform(0.1, 3.0, 100)
    y = ground(x) + sigma * rng.standard_normal(100)
    made = np.mean(((legendre_profile(x, y).height(x) - y) / sigma) ** 2)
    assert least_misfit(x, y, sigma, DEGREE) <= made


def test_where_points_cannot_tell_it_is_nought() -> None:
    x = np.concatenate([np.linspace(0.0, 1e-6, 99), [1000.0]])
    assert least_misfit(x, ground(x), np.ones(100), DEGREE) == 0.0


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
    assert smooth_profile(X, y, given, "legendre").method == "legendre"
    assert smooth_profile(X, y, given, "spline").method == "spline"


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
