"""Bounds of one volume: draws of friction, and stops that scatter by metres."""

from __future__ import annotations

import sys
from statistics import NormalDist
from typing import Literal

import numpy as np
import pytest

from avahazard.hazard.rows import Scenario, draw_stops, hazard_row, scattered_stops
from avahazard.notes import Note
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_curve import RunoutCurve, pieces
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.results.hazard import HazardRow
from tests.hazard.conftest import JUMPS
from tests.hazard.naive import naive_stop
from tests.physics.paths import spline_profile

Distribution = Literal["lognormal", "normal"]


def draw_runouts(curve, friction, scatter, distribution, n_draws, rng):  # type: ignore[no-untyped-def]
    """Stops along one curve; every friction has its equal part of the draws."""
    in_log = distribution == "lognormal"
    location = np.log(friction) if in_log else friction
    ends = np.arange(len(friction) + 1) * n_draws // len(friction)
    owner = np.repeat(np.arange(len(friction)), np.diff(ends))
    given = np.zeros(n_draws, np.int64), location[owner], scatter[owner], in_log
    return draw_stops(rng, *pieces(curve[None]), *given)


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
@pytest.mark.parametrize("n_draws", [3, 2000, 2003])
def test_draws_equal_the_twin(curve: RunoutCurve, distribution: Distribution, n_draws: int) -> None:
    rng = np.random.default_rng(5)
    friction = rng.uniform(0.2, 0.6, 7)
    scatter = rng.uniform(0.1, 0.3, 7)
    x, y, counts = draw_runouts(
        curve, friction, scatter, distribution, n_draws, np.random.default_rng(9)
    )
    z = np.random.default_rng(9).standard_normal(n_draws)
    owner = [p for p in range(7) for _ in range(p * n_draws // 7, (p + 1) * n_draws // 7)]
    if distribution == "lognormal":
        mu = friction[owner] * np.exp(scatter[owner] * z)
    else:
        mu = friction[owner] + scatter[owner] * z
    stops = np.array([naive_stop(curve, m, JUMPS) for m in mu if m > 0])
    np.testing.assert_allclose(x, stops[:, 0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(y, stops[:, 1], rtol=1e-9, atol=1e-9)
    assert counts.sum() == len(stops)
    assert counts[1] == np.isinf(stops[:, 0]).sum()


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
def test_the_generator_is_let_go(curve: RunoutCurve, distribution: Distribution) -> None:
    rng = np.random.default_rng(9)
    before = sys.getrefcount(rng)
    draw_runouts(curve, np.array([0.4]), np.array([0.1]), distribution, 10, rng)
    assert sys.getrefcount(rng) == before


def runout_bounds(curve, friction, scatter, distribution, n_draws, rng) -> HazardRow:  # type: ignore[no-untyped-def]
    x, y, counts = draw_runouts(curve, friction, scatter, distribution, n_draws, rng)
    n_held, interval = int(counts[NOT_RELEASED]), Note("of_parameters")
    return hazard_row(Scenario("p", 1e4), x, y, n_held, n_draws, interval)


def bounds(curve: RunoutCurve, friction: float, scatter: float, distribution: Distribution):
    return runout_bounds(
        curve,
        np.array([friction]),
        np.array([scatter]),
        distribution,
        200_000,
        np.random.default_rng(3),
    )


def test_quantiles_are_the_runouts_of_the_quantiles_of_friction(curve: RunoutCurve) -> None:
    found = bounds(curve, 0.45, 0.1, "lognormal")
    assert found.p_left_profile == 0
    z95 = 1.6448536
    slow, middle, fast = (naive_stop(curve, 0.45 * np.exp(0.1 * z), JUMPS) for z in (z95, 0, -z95))
    assert (found.runout_x_m.q05, found.runout_x_m.q50, found.runout_x_m.q95) == pytest.approx(
        (slow[0], middle[0], fast[0]), abs=3
    )
    assert (
        found.runout_elevation_m.q05,
        found.runout_elevation_m.q50,
        found.runout_elevation_m.q95,
    ) == pytest.approx((fast[1], middle[1], slow[1]), abs=3)
    assert found.runout_x_m.mean is not None
    assert slow[0] < found.runout_x_m.mean < fast[0]


def test_a_quantile_beyond_the_profile_is_unknown_and_so_is_the_mean(curve: RunoutCurve) -> None:
    found = bounds(curve, 0.25, 0.2, "lognormal")
    # left below 0.19375, the middle between the last left node and the first stop
    expected = NormalDist().cdf(np.log(0.19375 / 0.25) / 0.2)
    assert found.p_left_profile == pytest.approx(expected, abs=0.003)
    assert found.runout_x_m.q95 is None
    assert found.runout_x_m.q50 is not None
    assert found.runout_x_m.mean is None
    assert found.runout_elevation_m.q05 is None
    assert found.runout_elevation_m.q95 is not None
    assert found.runout_elevation_m.mean is None


def test_the_mean_is_over_the_stops_while_few_leave(curve: RunoutCurve) -> None:
    friction, scatter = np.array([0.29]), np.array([0.2])
    x, _, _ = draw_runouts(curve, friction, scatter, "lognormal", 50_000, np.random.default_rng(4))
    found = runout_bounds(curve, friction, scatter, "lognormal", 50_000, np.random.default_rng(4))
    assert 0.01 < found.p_left_profile < 0.04
    assert found.runout_x_m.mean == pytest.approx(x[np.isfinite(x)].mean())


def test_the_steps_are_quantiles_and_none_beyond_the_profile(curve: RunoutCurve) -> None:
    friction, scatter = np.array([0.25]), np.array([0.2])
    x, _, _ = draw_runouts(curve, friction, scatter, "lognormal", 4000, np.random.default_rng(4))
    found = runout_bounds(curve, friction, scatter, "lognormal", 4000, np.random.default_rng(4))
    expected = np.sort(x)[199::200][:19]
    assert found.runout_x_steps_m == tuple(q if np.isfinite(q) else None for q in expected)
    assert found.runout_x_steps_m[0] == found.runout_x_m.q05
    assert found.runout_x_steps_m[-1] is None


def test_everything_leaves(curve: RunoutCurve) -> None:
    found = bounds(curve, 0.12, 0.01, "lognormal")
    assert found.p_left_profile == 1
    assert found.runout_x_m.q05 is None
    assert found.runout_x_m.mean is None


def test_normal_friction_counts_the_draws_that_no_block_can_have(curve: RunoutCurve) -> None:
    found = bounds(curve, 0.45, 0.3, "normal")
    assert found.n_draws == 200_000
    assert found.n_nonpositive_friction / found.n_draws == pytest.approx(0.0668, abs=0.002)
    # of N(0.45, 0.3) above zero: below 0.19375, and from 0.64625
    assert found.p_left_profile == pytest.approx((0.1965 - 0.0668) / 0.9332, abs=0.004)
    assert found.p_not_released == pytest.approx(0.2565 / 0.9332, abs=0.004)
    assert bounds(curve, 0.45, 0.3, "lognormal").n_nonpositive_friction == 0


def test_only_impossible_draws_leave_nothing_to_report(curve: RunoutCurve) -> None:
    found = bounds(curve, -5.0, 0.1, "normal")
    assert found.n_nonpositive_friction == found.n_draws
    assert found.runout_x_m.q50 is None
    assert found.p_left_profile == 0


def test_parameter_uncertainty_widens_the_interval(curve: RunoutCurve) -> None:
    rng = np.random.default_rng(8)
    posterior = 0.45 * np.exp(0.05 * rng.standard_normal(4000))
    wide = runout_bounds(
        curve, posterior, np.full(4000, 0.05), "lognormal", 100_000, np.random.default_rng(1)
    )
    narrow = bounds(curve, 0.45, 0.05, "lognormal")
    widths = [b.runout_x_m.q95 - b.runout_x_m.q05 for b in (wide, narrow)]
    assert widths[0] / widths[1] == pytest.approx(2**0.5, rel=0.05)


def test_the_same_seed_gives_the_same_bounds(curve: RunoutCurve) -> None:
    assert bounds(curve, 0.4, 0.2, "normal") == bounds(curve, 0.4, 0.2, "normal")


def path(rise_m: float = 0.0) -> SmoothProfile:
    """A slope of 0.4 over 2000 m, then `rise_m` of counter-slope over 500 m if any."""
    x = np.arange(0.0, 2501.0 if rise_m else 2001.0, 20.0)
    y = np.where(x <= 2000.0, 2000.0 - 0.4 * x, 1200.0 + (x - 2000.0) * rise_m / 500.0)
    return spline_profile(x, y) if rise_m else smooth_profile(x, y)


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
