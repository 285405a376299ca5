"""The classes of avalanches to come."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.hazard.classes_to_come import classes_to_come, path_release_zone
from avahazard.records.collection import Records
from avahazard.records.event import Event
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
