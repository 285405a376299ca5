"""Synthetic datasets have the stated statistics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.synth import making
from avahazard.synth.dataset import Exponential, Power, Settings, make_track
from avahazard.synth.making import (
    RUN_ON_M,
    VALLEY_SLOPE,
    ahead,
    concave_profile,
    make_dataset,
    make_sites,
    uphill,
)
from tests.synth.datasets import dataset, residuals, truth_column


def test_same_seed_same_world_and_another_seed_another() -> None:
    one, two, other = (dataset(seed, n_events=60, n_paths=4) for seed in (1, 1, 2))
    assert one[0].events == two[0].events
    assert one[1] == two[1]
    assert one[0].events != other[0].events


def test_friction_follows_the_law_with_its_scatter() -> None:
    _, truth = dataset(3, n_events=3000, n_paths=6)
    volume, mu = truth_column(truth, "volume_m3"), truth_column(truth, "mu")
    slope, level = np.polyfit(volume, np.log(mu), 1)
    assert level == pytest.approx(np.log(0.5), abs=0.015)
    assert slope == pytest.approx(-7e-7, rel=0.1)
    assert residuals(truth).std() == pytest.approx(1.0, abs=0.05)


def test_power_law() -> None:
    _, truth = dataset(3, n_events=2000, n_paths=6, settings=Settings(law=Power()))
    assert truth["law"] == {"name": "power", "alpha": 1.83, "beta": 0.12}
    logs = np.log(truth_column(truth, "volume_m3")), np.log(truth_column(truth, "mu"))
    # What is too rough to start is undetected: with this law some of the smallest.
    assert np.polyfit(*logs, 1)[0] == pytest.approx(-0.12, abs=0.015)


def test_volumes_are_recorded_with_their_error() -> None:
    records, truth = dataset(4, n_events=2000, settings=Settings(volume_rel_sigma=0.4))
    recorded = np.array([e.volume_m3 for e in records.events])
    error = np.log(recorded / truth_column(truth, "volume_m3"))
    assert error.std() == pytest.approx(0.4, rel=0.05)
    assert abs(error.mean()) < 0.03
    assert {e.volume_rel_sigma for e in records.events} == {0.4}


def test_too_few_events_are_refused() -> None:
    with pytest.raises(AvahazardError, match="cannot be spread"):
        make_dataset(1, n_events=5, n_paths=9)


def test_avalanches_that_never_start_are_an_error() -> None:
    with pytest.raises(AvahazardError, match="Too few avalanches"):
        make_dataset(1, 20, 2, settings=Settings(law=Exponential(a=10.0)))


def events_of(truth: dict[str, Any]) -> list[dict[str, Any]]:
    """The true events."""
    return list(truth["events"])


@pytest.mark.parametrize("seed", range(5))
def test_paths_look_like_avalanche_paths(seed: int) -> None:
    made = make_sites(seed, 10, 250)
    assert sum(s.n_events for s in made) == 250
    assert len({s.n_events for s in made}) > 3
    assert {s.path.section for s in made} == {"channelled", "open"}
    for s in made:
        x, y = s.profile.x_m, s.profile.y_m
        assert s.drop_m is not None
        assert 580.0 < s.drop_m < 2080.0
        valley_m = VALLEY_SLOPE * RUN_ON_M
        assert s.drop_m <= y[0] - y.min() < s.drop_m + valley_m + 20.0
        assert 1200.0 < x[-1] - RUN_ON_M < 5600.0
        assert (y[0] - y[8]) / x[8] > 0.8
        assert abs((y[-2] - y[-1]) / (x[-1] - x[-2])) < 0.15


def test_profile_has_the_drop_and_the_slopes_asked_for() -> None:
    _, y = concave_profile(1000.0, 2400.0, slopes=(1.0, 0.1), power=1.5)
    assert y[0] == 2400.0
    assert y[-1] == pytest.approx(1400.0, abs=0.1 * 15.0)
    assert (y[0] - y[1]) / 15.0 == pytest.approx(1.0, abs=0.02)
    assert (np.diff(y) < 0.0).all()


def test_a_longer_end_moves_no_avalanche_that_stopped_before_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    longer, truth = make_dataset(0, 120, 6)
    monkeypatch.setattr(making, "_run_on", lambda x, y: (x, y))
    shorter, before = make_dataset(0, 120, 6)
    stops = list(zip(events_of(truth), events_of(before), strict=True))
    stopped = [(e, f) for e, f in stops if f["status"] == "stopped"]
    assert 100 < len(stopped) < 120
    assert all(abs(e["stop_x_m"] - f["stop_x_m"]) < 1.0 for e, f in stopped)
    assert [e.volume_m3 for e in longer.events] == [e.volume_m3 for e in shorter.events]
    releases = [[e.release_elevation_m or 0.0 for e in w.events] for w in (longer, shorter)]
    assert releases[0] == pytest.approx(releases[1], abs=2.0)
    assert not any(e.left_profile for e in longer.events)


def test_forest_stands_where_it_stood(monkeypatch: pytest.MonkeyPatch) -> None:
    def forest() -> list[list[float]]:
        return [
            [x for x, c in zip(p.x_m, p.land_cover or (), strict=True) if c == "forest"]
            for p in (s.profile for s in make_sites(0, 6, 120))
        ]

    now = forest()
    monkeypatch.setattr(making, "_run_on", lambda x, y: (x, y))
    assert now == forest()
    assert any(now)


# Down at 3 in 4 to x = 400 m, then up at the same slope: 5 m of path for 4 m of x.
X = np.arange(0.0, 801.0, 10.0)
TRACK = make_track(X, 1000.0 - 300.0 + 0.75 * np.abs(X - 400.0))


def test_front_is_ahead_along_the_path() -> None:
    stop, lead = np.array([100.0, 380.0, 780.0, 100.0]), np.array([50.0, 50.0, 99.0, 0.0])
    np.testing.assert_allclose(ahead(TRACK, stop, lead), [140.0, 420.0, 800.0, 100.0], atol=1.0)


def test_uphill_is_back_towards_the_release() -> None:
    rise = np.array([30.0, 30.0, 1e4, 0.0])
    found = uphill(TRACK, np.array([200.0, 440.0, 200.0, 123.0]), rise)
    np.testing.assert_allclose(found, [160.0, 360.0, 0.0, 123.0], atol=2.5)


def test_errors_of_records_shrink_with_the_year() -> None:
    records, truth = dataset(5, n_events=3000, n_paths=12)
    front, y = truth_column(truth, "front_x_m"), truth_column(truth, "front_elevation_m")
    by_year: dict[bool, list[float]] = {True: [], False: []}
    for event, x_true, y_true in zip(records.events, front, y, strict=True):
        if event.left_profile or event.year is None:
            continue
        assert (event.runout_x_m is None) != (event.runout_elevation_m is None)
        error = (
            event.runout_elevation_m - y_true
            if event.runout_elevation_m is not None
            else (event.runout_x_m or np.nan) - x_true
        )
        if event.year >= 1975:
            assert event.runout_sigma_m == 10.0
        by_year[event.year >= 1975].append(error / event.runout_sigma_m)
    for errors in by_year.values():
        assert np.std(errors) == pytest.approx(1.0, abs=0.06)
        assert abs(np.mean(errors)) < 0.1


def test_x_is_recorded_exactly_on_the_paths_that_rise_somewhere() -> None:
    records, _ = dataset(5, n_events=400, n_paths=12)
    rising = {p.path_id for p in records.profiles if (np.diff(p.y_m) >= 0.0).any()}
    assert 0 < len(rising) < 12
    for event in records.events:
        if not event.left_profile:
            assert (event.runout_x_m is not None) == (event.path_id in rising)


def test_an_event_beyond_the_profile_has_no_runout() -> None:
    light = Settings(law=Exponential(0.3, 3e-6))
    records, truth = dataset(5, n_events=400, settings=light)
    left = truth_column(truth, "status") == "left_profile"
    assert 0 < left.sum() < 200
    assert [e.left_profile for e in records.events] == left.tolist()
    assert all(
        e.runout_x_m is None and e.runout_elevation_m is None
        for e in records.events
        if e.left_profile
    )


def test_censored_paths_tell_their_limit_and_keep_to_it() -> None:
    records, truth = dataset(6, n_events=240, settings=Settings(censored_share=0.3))
    limit = {p.path_id: p.observed_below_m for p in records.paths}
    assert len(records.events) == 240
    assert truth["seen_below_m"] == limit
    y = truth_column(truth, "front_elevation_m")
    assert all(v <= limit[e.path_id] for v, e in zip(y, records.events, strict=True))
    whole, told = dataset(6, n_events=240)
    assert all(p.observed_below_m is None for p in whole.paths)
    above = np.mean(
        [
            v > limit[e.path_id]
            for v, e in zip(truth_column(told, "front_elevation_m"), whole.events, strict=True)
        ]
    )
    assert above == pytest.approx(0.3, abs=0.08)


def test_wrong_records_are_far_off_and_flagged() -> None:
    records, truth = dataset(7, n_events=1000, settings=Settings(wrong_share=0.1))
    wrong = truth_column(truth, "wrong_record")
    assert wrong.mean() == pytest.approx(0.1, abs=0.03)
    y = truth_column(truth, "front_elevation_m")
    far = np.array(
        [
            e.runout_elevation_m is not None
            and abs(e.runout_elevation_m - v) > 5 * e.runout_sigma_m
            for e, v in zip(records.events, y, strict=True)
        ]
    )
    assert not far[~wrong].any()
    in_y = np.array([e.runout_elevation_m is not None for e in records.events])
    assert far[wrong & in_y].mean() > 0.6


def test_speeds_are_measured_on_a_share_of_the_events() -> None:
    records, _ = dataset(8, n_events=200, settings=Settings(speeds=0.25))
    by_event: dict[str, list[float]] = {}
    for s in records.speeds:
        assert 1.0 <= s.speed_sigma_m_s <= 2.0
        assert s.x_m is not None
        by_event.setdefault(s.event_id, []).append(s.x_m)
    assert len(by_event) == 50
    assert np.mean([len(v) for v in by_event.values()]) > 8.0
    assert not dataset(8, n_events=200)[0].speeds


def test_decoys_are_noise_or_follow_what_they_say() -> None:
    records, truth = dataset(9, n_events=1000, settings=Settings(decoys=4))
    columns = {k: [e.covariates[f"decoy_{k}"] for e in records.events] for k in range(1, 5)}
    volume = np.log(truth_column(truth, "volume_m3"))
    release = np.array([e.release_elevation_m for e in records.events])
    assert abs(np.corrcoef(np.array(columns[1], float), volume)[0, 1]) < 0.1
    assert set(columns[2]) == {"x", "y", "z"}
    assert np.corrcoef(np.array(columns[3], float), volume)[0, 1] == pytest.approx(0.7, abs=0.06)
    assert np.corrcoef(np.array(columns[4], float), release)[0, 1] == pytest.approx(0.7, abs=0.06)


def test_deposits_give_the_recorded_volume() -> None:
    records, _ = dataset(9, n_events=100)
    for e in records.events:
        assert e.deposit_length_m is not None
        assert e.deposit_width_m is not None
        assert e.deposit_thickness_m is not None
        product = e.deposit_length_m * e.deposit_width_m * e.deposit_thickness_m / 2.0
        assert product == pytest.approx(e.volume_m3, rel=0.01)
