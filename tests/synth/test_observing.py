"""What is written down, against what happened."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.synth.settings import Exponential, Settings
from tests.synth.worlds import truth_column, world


def test_errors_of_records_shrink_with_the_year() -> None:
    records, truth = world(5, n_events=3000, n_paths=12)
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
    records, _ = world(5, n_events=400, n_paths=12)
    rising = {p.path_id for p in records.profiles if (np.diff(p.y_m) >= 0.0).any()}
    assert 0 < len(rising) < 12
    for event in records.events:
        if not event.left_profile:
            assert (event.runout_x_m is not None) == (event.path_id in rising)


def test_an_event_beyond_the_profile_has_no_runout() -> None:
    light = Settings(law=Exponential(0.3, 3e-6))
    records, truth = world(5, n_events=400, settings=light)
    left = truth_column(truth, "status") == "left_profile"
    assert 0 < left.sum() < 200
    assert [e.left_profile for e in records.events] == left.tolist()
    assert all(
        e.runout_x_m is None and e.runout_elevation_m is None
        for e in records.events
        if e.left_profile
    )


def test_censored_paths_tell_their_limit_and_keep_to_it() -> None:
    records, truth = world(6, n_events=240, settings=Settings(censored_share=0.3))
    limit = {p.path_id: p.observed_below_m for p in records.paths}
    assert len(records.events) == 240
    assert truth["seen_below_m"] == limit
    y = truth_column(truth, "front_elevation_m")
    assert all(v <= limit[e.path_id] for v, e in zip(y, records.events, strict=True))
    whole, told = world(6, n_events=240)
    assert all(p.observed_below_m is None for p in whole.paths)
    above = np.mean(
        [
            v > limit[e.path_id]
            for v, e in zip(truth_column(told, "front_elevation_m"), whole.events, strict=True)
        ]
    )
    assert above == pytest.approx(0.3, abs=0.08)


def test_wrong_records_are_far_off_and_flagged() -> None:
    records, truth = world(7, n_events=1000, settings=Settings(wrong_share=0.1))
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
    records, _ = world(8, n_events=200, settings=Settings(speeds=0.25))
    by_event: dict[str, list[float]] = {}
    for s in records.speeds:
        assert 1.0 <= s.speed_sigma_m_s <= 2.0
        assert s.x_m is not None
        by_event.setdefault(s.event_id, []).append(s.x_m)
    assert len(by_event) == 50
    assert np.mean([len(v) for v in by_event.values()]) > 8.0
    assert not world(8, n_events=200)[0].speeds


def test_decoys_are_noise_or_follow_what_they_say() -> None:
    records, truth = world(9, n_events=1000, settings=Settings(decoys=4))
    columns = {k: [e.covariates[f"decoy_{k}"] for e in records.events] for k in range(1, 5)}
    volume = np.log(truth_column(truth, "volume_m3"))
    release = np.array([e.release_elevation_m for e in records.events])
    assert abs(np.corrcoef(np.array(columns[1], float), volume)[0, 1]) < 0.1
    assert set(columns[2]) == {"x", "y", "z"}
    assert np.corrcoef(np.array(columns[3], float), volume)[0, 1] == pytest.approx(0.7, abs=0.06)
    assert np.corrcoef(np.array(columns[4], float), release)[0, 1] == pytest.approx(0.7, abs=0.06)


def test_deposits_give_the_recorded_volume() -> None:
    records, _ = world(9, n_events=100)
    for e in records.events:
        assert e.deposit_length_m is not None
        assert e.deposit_width_m is not None
        assert e.deposit_thickness_m is not None
        product = e.deposit_length_m * e.deposit_width_m * e.deposit_thickness_m / 2.0
        assert product == pytest.approx(e.volume_m3, rel=0.01)
