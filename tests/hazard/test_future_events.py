"""The classes of future avalanches, and the release zone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.columns import build_columns, counted
from avahazard.effects.effect import FrictionEffect
from avahazard.hazard.future_events import (
    classes_of,
    classes_to_come,
    path_release_zone,
    release_zone,
    stated_zone,
)
from avahazard.records.collection import Event, Records
from tests.workflow.worlds import bowl


def records(n: int, spread: float = 0.0) -> Records:
    events = tuple(
        Event(
            f"e{k}",
            path_id="B",
            runout_x_m=1000.0,
            release_elevation_m=900.0 + spread * k,
            covariates={"snow_type": "wet" if k % 2 else "dry"},
        )
        for k in range(n)
    )
    return bowl(events=events)


def test_one_release_and_no_columns_are_one_class() -> None:
    (event,) = classes_to_come(records(10), "B", 2e4, event_columns=False)
    assert (event.volume_m3, event.release_elevation_m) == (2e4, None)
    assert event.covariates == {}


def test_releases_are_spread_over_their_zone() -> None:
    found = classes_to_come(records(10, 8.0), "B", 2e4, event_columns=False)
    releases = sorted(e.release_elevation_m or 0.0 for e in found)
    zone = path_release_zone(records(10, 8.0), "B")
    assert zone is not None
    np.testing.assert_allclose(releases, zone.elevations())


def test_columns_are_those_of_the_records_at_several_releases() -> None:
    found = classes_to_come(records(4), "B", 2e4, event_columns=True)
    assert [e.covariates["snow_type"] for e in found] == ["dry", "wet"] * 2
    spread = classes_to_come(records(6, 20.0), "B", 2e4, event_columns=True)
    assert len(spread) == 12
    wet = [e.release_elevation_m for e in spread if e.covariates["snow_type"] == "wet"]
    assert len(set(wet)) == 6


def test_classes_are_counted_as_the_events_that_they_stand_for() -> None:
    known = records(6)
    days = [f"1999-0{1 + k // 2}-0{1 + k % 2}" for k in range(6)]
    dated = [replace(e, date=day) for e, day in zip(known.events, days, strict=True)]
    there = replace(known, events=tuple(dated))
    columns = build_columns(dated, {p.path_id: p for p in there.paths}, np.full(6, np.nan))
    events = classes_to_come(there, "B", 2e4, event_columns=True)
    made = classes_of(replace(there, events=events), columns).columns.made
    for name, values in counted(columns, columns).items():
        np.testing.assert_array_equal(made[name], values)


def test_they_come_in_the_last_winter_of_the_records() -> None:
    known = records(4)
    days: tuple[str | None, ...] = ("1961-12-05", "1990", None, "1998-02-03")
    dated = [replace(e, date=day) for e, day in zip(known.events, days, strict=True)]
    there = replace(known, events=tuple(dated))
    columns = build_columns(dated, {p.path_id: p for p in there.paths}, np.full(4, np.nan))
    events = classes_to_come(there, "B", 2e4, event_columns=True)[:4]
    found = classes_of(replace(there, events=events), columns).columns
    assert found.winter.tolist() == [1998.0] * 4
    assert found.year.tolist() == [1997.0, 1998.0, 1998.0, 1998.0]
    np.testing.assert_array_equal(found.day_of_winter, columns.day_of_winter)
    change = definition("change:all").build({"from_year": 1995.0})
    assert isinstance(change, FrictionEffect)
    assert change.design(found).tolist() == [[1.0]] * 4


def test_no_more_classes_than_the_runs_can_bear() -> None:
    assert len(classes_to_come(records(100, 1.0), "B", 2e4, event_columns=True)) == 24


def test_a_path_without_records_is_like_all_others() -> None:
    known = records(4)
    both = Records(
        (*known.paths, replace(known.paths[0], path_id="C")),
        (*known.profiles, replace(known.profiles[0], path_id="C")),
        known.events,
    )
    found = classes_to_come(both, "C", 2e4, event_columns=True)
    assert [e.covariates["snow_type"] for e in found] == ["dry", "wet"] * 2
    assert {e.path_id for e in found} == {"C"}


def test_a_zone_that_the_path_states_is_that_of_avalanches_to_come() -> None:
    known = records(0)
    (path,) = known.paths
    stated = replace(path, release_elevation_m=880.0, covariates={"release_sigma_m": 30.0})
    found = classes_to_come(replace(known, paths=(stated,)), "B", 2e4, event_columns=False)
    releases = [e.release_elevation_m or 0.0 for e in found]
    assert np.mean(releases) == 880.0
    assert 0.9 * 30.0 < np.std(releases) < 30.0


def test_recorded_releases_are_freed_of_their_errors() -> None:
    exact = records(10, 8.0)
    (path,) = exact.paths
    vague = replace(exact, paths=(replace(path, covariates={"release_sigma_m": 18.0}),))
    sharp, freed = (path_release_zone(r, "B") for r in (exact, vague))
    assert sharp is not None
    assert freed is not None
    recorded = np.var([e.release_elevation_m or 0.0 for e in exact.events], ddof=1)
    left = np.sqrt(1.0 - 18.0**2 / recorded)
    spread = [np.std(zone.elevations(200)) for zone in (freed, sharp)]
    np.testing.assert_allclose(spread[0], left * spread[1], rtol=0.02)


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
