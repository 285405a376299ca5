"""Runouts of return periods on the parabola, where everything is known."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.avalanches import EventVolumes, annual_rate, one_volume
from avahazard.hazard.exceedance import (
    at_the_middle,
    at_volume,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    reach,
    runout_interval,
)
from avahazard.hazard.rows import volume_bounds
from avahazard.hazard.runout_bounds import spread
from tests.hazard.parabola import LAW, TOP_M, avalanches_of, draws, path, stop, stops

VOLUME = 1e5
MEDIAN = np.exp(LAW[0] - LAW[1] * VOLUME * 1e-6)
SIGMA = 0.1


def test_one_volume_and_no_scatter_is_the_deterministic_stop_by_both_ways() -> None:
    deterministic = stop(MEDIAN)
    coordinates = draws(1e-9, 4)
    avalanches = avalanches_of(coordinates, one_volume(VOLUME, 4, rate=0.2))
    for period in (10.0, 100.0, 300.0):
        mixed = exceeded_runout(avalanches, period)
        assert mixed == pytest.approx([deterministic] * 4, abs=0.5)
    given = path(coordinates, None, at=[VOLUME])
    bounds = volume_bounds(given, VOLUME, 100, np.random.default_rng(0))
    assert (bounds.x.q05, bounds.x.q95) == pytest.approx((deterministic,) * 2, abs=0.5)
    assert middle_runout(avalanches) == pytest.approx([deterministic] * 4, abs=0.5)
    assert natural_runouts(avalanches) == pytest.approx(deterministic, abs=0.5)


def test_one_volume_is_exceeded_at_its_quantile_of_friction() -> None:
    rate, period = 0.4, 50.0
    avalanches = avalanches_of(draws(SIGMA, 1), one_volume(VOLUME, 1, rate))
    share = annual_rate(period) / rate
    z = float(np.quantile(np.random.default_rng(1).standard_normal(1_000_000), share))
    expected = stop(MEDIAN * np.exp(SIGMA * z))
    assert exceeded_runout(avalanches, period) == pytest.approx([expected], abs=4.0)


def test_the_runout_is_exceeded_as_often_in_simulated_years() -> None:
    volumes = EventVolumes(np.array([0.7]), np.log([1e4, 4e4, 8e4]), np.array([[0.5, 0.4, 0.1]]))
    avalanches = avalanches_of(draws(SIGMA, 1), volumes, (TOP_M, 2350.0))
    (x,) = exceeded_runout(avalanches, 20.0)
    assert np.isfinite(x)
    rng = np.random.default_rng(5)
    n_years = 100_000
    count = rng.poisson(0.7, n_years)
    year = np.repeat(np.arange(n_years), count)
    volume = rng.choice(np.exp(volumes.log_volume), size=len(year), p=volumes.share[0])
    mu = np.exp(LAW[0] - LAW[1] * 1e-6 * volume + SIGMA * rng.standard_normal(len(year)))
    runout = np.where(rng.random(len(year)) < 0.5, stops(mu, TOP_M), stops(mu, 2350.0))
    farthest = np.zeros(n_years)
    np.maximum.at(farthest, year, runout)
    assert np.mean(farthest > x) == pytest.approx(1 / 20, abs=0.002)


def test_the_chance_of_reaching_falls_to_one_in_t_at_the_runout_of_t() -> None:
    avalanches = avalanches_of(draws(SIGMA, 2), one_volume(VOLUME, 2, 0.3))
    found = reach(avalanches, 400)
    assert (np.diff(found.chance[:, 1]) <= 0.0).all()
    assert found.chance[0, 1] == pytest.approx(-np.expm1(-0.3), rel=1e-3)
    for period in (10.0, 100.0):
        x = float(np.interp(-1 / period, -found.chance[:, 1], found.x))
        assert exceeded_runout(avalanches, period)[0] == pytest.approx(x, abs=6.0)


def test_natural_and_parameters_apart() -> None:
    rng = np.random.default_rng(6)
    coordinates = draws(SIGMA, 400)
    coordinates[:, 0] += 0.05 * rng.standard_normal(400)
    avalanches = avalanches_of(coordinates, one_volume(VOLUME, 400))
    natural = spread(natural_runouts(avalanches))
    parameters = spread(middle_runout(avalanches))
    for found, sd in ((natural, SIGMA), (parameters, 0.05)):
        for z, value in ((1.645, found.q05), (0.0, found.q50), (-1.645, found.q95)):
            assert value == pytest.approx(stop(MEDIAN * np.exp(sd * z)), rel=0.03)


def test_the_middle_is_one_draw_of_medians_whose_shares_add_up() -> None:
    share = np.array([[0.7, 0.2, 0.1], [0.1, 0.7, 0.2], [0.2, 0.1, 0.7]])
    volumes = EventVolumes(np.array([0.2, 0.5, 0.3]), np.log([1e4, 4e4, 8e4]), share)
    middle = at_the_middle(avalanches_of(draws(SIGMA, 3), volumes))
    assert middle.n_parameters == 1
    assert middle.volumes.rate == pytest.approx([0.3])
    np.testing.assert_allclose(middle.volumes.share, np.full((1, 3), 1.0 / 3.0))


def test_more_rate_and_a_longer_period_go_farther() -> None:
    volumes = EventVolumes(np.array([0.05, 0.2]), np.log([VOLUME]), np.ones((2, 1)))
    avalanches = avalanches_of(draws(SIGMA, 2), volumes)
    often, seldom = exceeded_runout(avalanches, 50.0), exceeded_runout(avalanches, 500.0)
    assert often[0] < often[1] < seldom[1]
    assert often[0] < seldom[0]


def test_a_period_in_which_nothing_comes_has_the_release() -> None:
    avalanches = avalanches_of(draws(SIGMA, 1), one_volume(VOLUME, 1, rate=0.01))
    assert exceeded_runout(avalanches, 10.0) == pytest.approx(avalanches.site.release_x)


def test_beyond_the_profile() -> None:
    avalanches = avalanches_of(draws(SIGMA, 3), one_volume(2e6, 3, rate=5.0))
    x = exceeded_runout(avalanches, 300.0)
    assert np.isinf(x).all()
    found = runout_interval(avalanches, x, "what varies")
    x_m, elevation_m = found.runout_x_m, found.runout_elevation_m
    assert (x_m.q50, elevation_m.q50, x_m.mean) == (None, None, None)
    assert found.interval == "what varies"


def test_a_volume_between_the_nodes() -> None:
    nodes = EventVolumes(np.ones(2), np.linspace(9.0, 13.0, 41), np.full((2, 41), 1 / 41))
    avalanches = avalanches_of(draws(SIGMA, 2), nodes)
    exact = avalanches_of(draws(SIGMA, 2), one_volume(VOLUME, 2))
    between = at_volume(avalanches, np.full(2, np.log(VOLUME)))
    np.testing.assert_allclose(between.location, exact.location, atol=2e-4)
    np.testing.assert_allclose(at_the_middle(exact).location[0], exact.location[0])


def test_stops_that_scatter_in_metres_agree_with_the_paper_s_way() -> None:
    coordinates = draws(60.0, 50)
    given = path(coordinates, one_volume(VOLUME, 50), metres=True, at=[VOLUME])
    avalanches = given.avalanches
    natural = runout_interval(avalanches, natural_runouts(avalanches), "nature")
    bounds = volume_bounds(given, VOLUME, 40_000, np.random.default_rng(0))
    for key in ("q05", "q50", "q95"):
        assert getattr(natural.runout_elevation_m, key) == pytest.approx(
            getattr(bounds.elevation, key), abs=3.0
        )


def test_the_friction_of_a_volume_lies_between_that_of_its_neighbours() -> None:
    volumes = EventVolumes(np.ones(3), np.log([1e4, 1e5]), np.full((3, 2), 0.5))
    mixed = avalanches_of(draws(SIGMA, 3), volumes)
    small, large = mixed.location[0, 0]
    assert small > large
    found = at_volume(mixed, np.log([1e4, 10**4.5, 1e6]))
    assert found.location[:, 0, 0] == pytest.approx([small, 0.5 * (small + large), large])
    assert found.scatter == pytest.approx(SIGMA)
    assert found.volumes.share.shape == (3, 1)
