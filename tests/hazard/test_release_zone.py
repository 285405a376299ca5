import numpy as np
import pytest

from avahazard.hazard.release_zone import release_zone, stated_zone


def test_mean_and_spread_are_those_of_the_records() -> None:
    rng = np.random.default_rng(1)
    recorded = 2000.0 + 300.0 * rng.beta(2.0, 3.0, 4000)
    zone = release_zone(recorded, 2500.0)
    assert zone is not None
    assert (zone.a, zone.b) == pytest.approx((2.0, 3.0), rel=0.15)
    drawn = zone.elevations(200)
    assert np.mean(drawn) == pytest.approx(np.mean(recorded), abs=1.0)
    assert np.std(drawn) == pytest.approx(np.std(recorded), rel=0.02)
    assert (np.diff(drawn) > 0.0).all()


def test_the_zone_stays_under_the_top() -> None:
    zone = release_zone(np.array([2100.0, 2150.0, 2200.0, 2240.0, 2249.0]), 2250.0)
    assert zone is not None
    assert zone.high_m == 2250.0
    assert zone.low_m == pytest.approx(2100.0 - 149.0 / 4)
    # A record above the profile's top, by the error of a map.
    assert release_zone(np.array([2100.0, 2150.0, 2200.0, 2240.0, 2260.0]), 2250.0) is not None


@pytest.mark.parametrize("recorded", [[], [2100.0, 2200.0, 2150.0, 2120.0], [2100.0] * 9])
def test_one_place_is_no_zone(recorded: list[float]) -> None:
    assert release_zone(np.array(recorded), 2300.0) is None


def test_records_at_both_ends_only() -> None:
    zone = release_zone(np.array([2000.0] * 3 + [2200.0] * 3), 2300.0)
    assert zone is not None
    assert np.isfinite(zone.elevations()).all()


def test_avalanches_to_come_have_the_spread_without_the_error_of_the_records() -> None:
    rng = np.random.default_rng(1)
    sigma = rng.uniform(20.0, 60.0, 4000)
    true = 2000.0 + 200.0 * rng.beta(2.0, 2.0, 4000)
    zone = release_zone(true + sigma * rng.standard_normal(4000), 2500.0, sigma)
    assert zone is not None
    drawn = zone.elevations(200)
    assert np.mean(drawn) == pytest.approx(np.mean(true), abs=2.0)
    assert np.std(drawn) == pytest.approx(np.std(true), rel=0.05)


def test_records_that_differ_by_their_errors_alone_are_one_place() -> None:
    recorded = np.random.default_rng(2).normal(2100.0, 30.0, 40)
    zone = release_zone(recorded, 2500.0, 35.0)
    assert zone is not None
    drawn = zone.elevations()
    assert np.mean(drawn) == pytest.approx(np.mean(recorded), abs=1.0)
    assert np.std(drawn) < 10.0


def test_a_stated_zone_has_that_spread() -> None:
    zone = stated_zone(2000.0, 50.0)
    assert zone is not None
    drawn = zone.elevations(200)
    assert (np.mean(drawn), np.std(drawn)) == pytest.approx((2000.0, 50.0), rel=0.01)
    assert stated_zone(2000.0, 5.0) is None


def test_few_records_have_the_moments_of_a_beta() -> None:
    zone = release_zone(np.array([2000.0, 2030.0, 2060.0, 2070.0, 2120.0]), 2500.0)
    assert zone is not None
    # They reach one spacing of 30 m past both ends: 1970 to 2150 m.
    assert (zone.low_m, zone.high_m) == (1970.0, 2150.0)
    share = np.array([30.0, 60.0, 90.0, 100.0, 150.0]) / 180.0
    mean, variance = np.mean(share), np.sum((share - np.mean(share)) ** 2) / 4.0
    # Mean and variance of Beta(a, b).
    a, b = zone.a, zone.b
    assert a / (a + b) == pytest.approx(mean)
    assert a * b / ((a + b) ** 2 * (a + b + 1.0)) == pytest.approx(variance)
