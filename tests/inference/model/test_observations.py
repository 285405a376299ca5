"""Records as the likelihood has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.model.observations import (
    ELEVATION,
    FRICTION_CORRELATION_M,
    LEFT,
    LENGTH,
    PLACE,
    SpeedRecord,
    build_observations,
    track_spread,
)
from avahazard.physics.cells import GRAVITY
from avahazard.records.collection import Event, Path, Profile, Records, Speed
from avahazard.records.errors import AvahazardError

X = np.linspace(0.0, 1900.0, 96)


def _profile(name: str, top: float) -> Profile:
    return Profile(name, X, top - 0.8 * X + 2e-4 * X**2)


EVENTS = (
    Event("y", "P", runout_elevation_m=400.0, runout_sigma_m=12.0, volume_m3=1e4),
    Event("x", "Q", runout_x_m=1500.0, runout_elevation_m=333.0, release_elevation_m=1900.0),
    Event("left", "P", left_profile=True, release_elevation_m=900.0),
    Event("straight", fall_height_m=500.0, runout_length_m=1200.0, volume_m3=3e4),
    Event("again", "P", runout_elevation_m=410.0, release_elevation_m=900.0),
)
RECORDS = Records(
    paths=(Path("P", release_elevation_m=950.0, observed_below_m=600.0), Path("Q"), Path("unused")),
    profiles=(_profile("P", 1000.0), _profile("Q", 2000.0)),
    events=EVENTS,
    speeds=(
        Speed("x", 30.0, 3.0, x_m=900.0),
        Speed("y", 12.0, 1.0, x_m=500.0),
        Speed("x", 25.0, 2.5, elevation_m=1800.0),
        Speed("elsewhere", 1.0, 1.0, x_m=1.0),
        Speed("straight", 9.0, 1.0, x_m=100.0),
    ),
)


def test_what_was_recorded() -> None:
    observations = build_observations(RECORDS)
    assert observations.n_events == 5
    assert observations.kind.tolist() == [ELEVATION, PLACE, LEFT, LENGTH, ELEVATION]
    expected = [400.0, 1500.0, np.nan, 1200.0, 410.0]
    assert observations.observed == pytest.approx(np.array(expected), nan_ok=True)
    assert observations.sigma.tolist() == [12.0, 10.0, 10.0, 10.0, 10.0]
    nan = np.nan
    assert observations.fall_height == pytest.approx(
        np.array([nan, nan, nan, 500.0, nan]), nan_ok=True
    )
    assert observations.limit == pytest.approx(
        np.array([600.0, nan, 600.0, nan, 600.0]), nan_ok=True
    )


def test_releases_are_the_events_own_else_the_paths_else_the_top() -> None:
    observations = build_observations(RECORDS)
    assert [site.path.path_id for site in observations.sites] == ["P", "Q"]
    assert observations.columns.paths == ("P", "Q")
    expected = [950.0, 1900.0, 900.0, np.nan, 900.0]
    got = observations.columns.release_elevation
    assert got == pytest.approx(np.array(expected), nan_ok=True, abs=1e-4)
    for i in (0, 1, 2, 4):
        site = observations.sites[observations.columns.path_index[i]]
        assert site.smooth.height(site.release_x[observations.release[i]]) == pytest.approx(got[i])
    assert observations.release[2] == observations.release[4]
    assert len(observations.sites[0].release_x) == 2


def test_speeds_are_sorted_along_the_track_and_belong_to_an_event() -> None:
    observations = build_observations(RECORDS)
    assert [measured.event for measured in observations.speeds] == [0, 1]
    track = observations.speeds[1]
    assert track.speed.tolist() == [25.0, 30.0]
    assert track.sigma.tolist() == [2.5, 3.0]
    assert track.x[1] == 900.0
    assert observations.sites[1].smooth.height(track.x[0]) == pytest.approx(1800.0, abs=1e-4)


def test_to_predict_volumes_are_read_in_the_light_of_the_past() -> None:
    past = replace(
        RECORDS, events=tuple(replace(EVENTS[0], event_id=str(k), volume_m3=1e6) for k in range(9))
    )
    alone = build_observations(RECORDS)
    informed = build_observations(RECORDS, build_observations(past))
    assert informed.volumes.population.centre == build_observations(past).volumes.population.centre
    assert informed.volumes.mean[0] > alone.volumes.mean[0] + 1.0


def test_events_to_predict_are_counted_among_those_known() -> None:
    def on(day: str, name: str = "new") -> Records:
        return replace(RECORDS, events=(replace(EVENTS[0], event_id=name, date=day),), speeds=())

    past = build_observations(on("1999-01-10", "past"))
    new = on("1999-01-12")
    made = build_observations(new, past).columns.made
    assert {name: values[0] for name, values in made.items()} == {
        "order_in_winter": 2.0,
        "days_since_last": 2.0,
        "avalanches_nearby": 0.0,  # counted as one of those known
        "volume_in_winter": pytest.approx(np.log(1e4)),
    }
    among = replace(new, events=(*new.events, *on("1999-01-10", "past").events))
    columns = build_observations(among).columns
    assert build_observations(new, past, among=columns).columns.made["avalanches_nearby"] == [1.0]
    assert build_observations(new).columns.made["order_in_winter"] == [1.0]


def test_what_cannot_be_arranged() -> None:
    with pytest.raises(AvahazardError, match="no events") as empty:
        build_observations(Records())
    assert "avahazard import" in empty.value.hint
    bare = replace(RECORDS, profiles=RECORDS.profiles[:1])
    with pytest.raises(AvahazardError, match="No profile is stored for path Q"):
        build_observations(bare)


WAY = np.array([0.0, 40.0, 150.0, 300.0, 480.0])
TRACK_M = 500.0


def integrated(n: int, seed: int) -> np.ndarray:
    """r at `WAY` for `n` tracks `[n, n_places]`: uneven friction added up step by step."""
    rng = np.random.default_rng(seed)
    step = 2.0
    fade = np.exp(-step / FRICTION_CORRELATION_M)
    n_steps = int(TRACK_M / step)
    friction = np.empty((n, n_steps))
    friction[:, 0] = rng.standard_normal(n)
    for k in range(1, n_steps):
        fresh = rng.standard_normal(n) * np.sqrt(1.0 - fade**2)
        friction[:, k] = fade * friction[:, k - 1] + fresh
    friction -= friction.mean(axis=1, keepdims=True)
    work = np.concatenate([np.zeros((n, 1)), np.cumsum(friction, axis=1) * step], axis=1)
    return -2.0 * GRAVITY * work[:, (WAY / step).astype(int)]


def test_the_spread_is_that_of_friction_added_up() -> None:
    made = np.cov(integrated(20_000, 1).T)
    spread = track_spread(WAY, TRACK_M)
    scale = np.sqrt(np.maximum(np.diag(spread), 1.0))
    assert np.max(np.abs(made - spread) / np.outer(scale, scale)) < 0.05


def test_speeds_are_certain_at_the_release_and_at_the_stop() -> None:
    spread = track_spread(np.array([0.0, 250.0, TRACK_M]), TRACK_M)
    assert spread[1, 1] > 1e6
    assert np.max(np.abs(spread[[0, 2]])) < 1e-6 * spread[1, 1]


def test_the_root_is_one_of_the_spread() -> None:
    speed = np.full(5, 10.0)
    one = SpeedRecord(3, 100.0 + WAY, speed, np.ones(5), 100.0, 100.0 + TRACK_M)
    np.testing.assert_allclose(one.root @ one.root.T, one.spread, atol=1e-6 * one.spread.max())
    assert one.share == pytest.approx(WAY / TRACK_M)


def test_a_place_above_the_release_or_below_the_stop_is_borne() -> None:
    x = np.array([-50.0, 10.0, 700.0])
    one = SpeedRecord(0, x, np.zeros(3), np.ones(3), 0.0, 500.0)
    assert one.share[0] == 0.0
    assert np.all(np.isfinite(one.root))
    held = SpeedRecord(0, x, np.zeros(3), np.ones(3), 600.0, 500.0)
    assert np.all(np.isfinite(held.spread))


def test_columns_that_are_the_stop_are_no_columns() -> None:
    rng = np.random.default_rng(2)
    height, reach = rng.uniform(300.0, 900.0, 30), rng.uniform(700.0, 2500.0, 30)
    events = tuple(
        Event(
            f"e{i}",
            fall_height_m=h,
            runout_length_m=length,
            covariates={"reach_deg": round(np.degrees(np.arctan(h / length)), 1), "slope": s},
        )
        for i, (h, length, s) in enumerate(zip(height, reach, rng.normal(size=30), strict=True))
    )
    found = build_observations(Records(events=events))
    assert set(found.outcomes) == {"reach_deg"}
    assert found.outcomes["reach_deg"] > 0.99
    assert set(found.columns.numbers) == {"fall_height_m", "slope"}
    assert build_observations(Records(events=events[:8]), found).outcomes == {}


def test_distances_on_each_path_are_the_stop() -> None:
    rng = np.random.default_rng(3)
    paths, profiles = (Path("P"), Path("Q")), (_profile("P", 900.0), _profile("Q", 2400.0))
    x = rng.uniform(900.0, 1700.0, 24)
    events = tuple(
        Event(f"e{i}", "PQ"[i % 2], runout_x_m=v, covariates={"distance": v * (1 + i % 2) + 7.0})
        for i, v in enumerate(x)
    )
    found = build_observations(Records(paths, profiles, events))
    assert set(found.outcomes) == {"distance"}
    assert found.columns.numbers == {}
