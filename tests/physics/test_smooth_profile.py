from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Legendre

from avahazard.physics.smooth_profile import (
    MISFIT_LIMIT_M,
    SPLINE_DEVIATION_M,
    legendre_profile,
    smooth_profile,
    spline_profile,
)
from tests.physics import naive
from tests.physics.paths import read_profiles

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


@pytest.mark.parametrize(("deviation", "method"), [(0.99, "legendre"), (1.01, "spline")])
def test_auto_turns_to_the_spline_above_the_limit(deviation: float, method: str) -> None:
    y = bumpy(30.0)  # the fit is linear in y, so the deviation scales with it
    y = y * deviation * MISFIT_LIMIT_M / legendre_profile(X, y).max_deviation_m
    assert smooth_profile(X, y).method == method
    assert smooth_profile(X, y, "legendre").method == "legendre"
    assert smooth_profile(X, y, "spline").method == "spline"


def test_the_spline_is_the_stiffest_within_its_deviation(shared_data) -> None:
    from scipy.interpolate import make_smoothing_spline  # noqa: PLC0415

    for x, y in read_profiles(shared_data / "tyrol-profiles" / "profiles.csv").values():
        fitted = spline_profile(x, y)
        assert np.max(np.abs(fitted.height(x) - y)) <= SPLINE_DEVIATION_M
        assert fitted.max_deviation_m == np.max(np.abs(fitted.height(x) - y))
        stiffer = make_smoothing_spline(x, y, lam=1.01 * fitted.smoothing)
        assert np.max(np.abs(stiffer(x) - y)) > SPLINE_DEVIATION_M


@pytest.mark.parametrize("fit", [legendre_profile, spline_profile])
def test_derivatives_agree_with_differences(fit) -> None:
    fitted = fit(X, bumpy(15.0))
    at, h = np.linspace(X[0] + 1.0, X[-1] - 1.0, 200), 0.05
    before, here, after = (fitted.derivatives(at + s * h) for s in (-1, 0, 1))
    np.testing.assert_allclose(here[1], (after[0] - before[0]) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(here[2], (after[1] - before[1]) / (2 * h), atol=1e-4)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_few_points_lower_the_degree(n: int) -> None:
    x, y = np.linspace(0.0, 900.0, n), np.linspace(800.0, 350.0, n)
    fitted = smooth_profile(x, y)
    assert fitted.degree == n - 1
    np.testing.assert_allclose(fitted.height([150.0, 450.0]), [725.0, 575.0], atol=1e-6)


def test_few_points_that_no_polynomial_follows_take_the_spline() -> None:
    x, y = np.array([0.0, 60.0, 3000.0]), np.array([2500.0, 400.0, 0.0])
    fitted = smooth_profile(x, y)
    assert fitted.method == "spline"
    assert np.max(np.abs(fitted.height(x) - y)) <= SPLINE_DEVIATION_M
    assert spline_profile(x[:2], y[:2]).height(30.0) == pytest.approx(1450.0, abs=5.0)
