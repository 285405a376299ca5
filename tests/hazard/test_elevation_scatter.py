"""Stops that scatter in elevation."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.runout_bounds import scattered_stops
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile


def path(rise_m: float = 0.0) -> SmoothProfile:
    """A slope of 0.4 over 2000 m, then `rise_m` of counter-slope over 500 m if any."""
    x = np.arange(0.0, 2501.0 if rise_m else 2001.0, 20.0)
    y = np.where(x <= 2000.0, 2000.0 - 0.4 * x, 1200.0 + (x - 2000.0) * rise_m / 500.0)
    return smooth_profile(x, y, method="spline" if rise_m else "auto")


def draws(smooth: SmoothProfile, elevation: float, sigma: float, n: int = 20_000):
    rng = np.random.default_rng(6)
    return scattered_stops(smooth, 100.0, np.full(n, elevation), np.full(n, sigma), rng)


def test_elevations_scatter_by_sigma_and_lie_on_the_path() -> None:
    x, y, held = draws(path(), 1500.0, 50.0)
    z = np.random.default_rng(6).standard_normal(len(y))
    np.testing.assert_allclose(y, 1500.0 + 50.0 * z)
    np.testing.assert_allclose(x, (2000.0 - y) / 0.4, atol=1.0)
    assert held == 0


def test_stops_below_the_end_have_left_and_those_above_the_release_are_held() -> None:
    x, y, held = draws(path(), 1500.0, 300.0)
    z = np.random.default_rng(6).standard_normal(len(y))
    assert np.isinf(x).sum() == pytest.approx((z < -1.0).sum(), abs=30)
    assert np.all(np.isneginf(y[np.isinf(x)]))
    assert held == pytest.approx((z > 460.0 / 300.0).sum(), abs=30)
    assert x.min() == 100.0


def test_what_left_stays_left() -> None:
    x, y, _ = scattered_stops(
        path(), 100.0, np.array([-np.inf, 1500.0]), np.array([10.0, 10.0]), np.random.default_rng(1)
    )
    assert np.isinf(x).tolist() == [True, False]
    assert np.isneginf(y).tolist() == [True, False]


def test_nothing_is_lower_than_the_floor_of_a_valley() -> None:
    smooth = path(rise_m=80.0)
    x, y, _ = draws(smooth, 1220.0, 40.0)
    places = np.linspace(100.0, smooth.x_max, 4001)
    floor = smooth.height(places)
    assert np.isfinite(x).all()
    assert y.min() == pytest.approx(floor.min(), abs=1e-9)
    assert x.max() == pytest.approx(places[floor.argmin()], abs=1.0)
    left, _, _ = scattered_stops(
        smooth, 100.0, np.array([-np.inf]), np.array([1.0]), np.random.default_rng(1)
    )
    assert np.isinf(left).all()
