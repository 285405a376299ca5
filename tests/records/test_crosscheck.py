"""Records against each other, those of the database included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.records.collection import Event, Path, Profile, Records, Speed
from avahazard.records.crosscheck import (
    check_places,
    check_references,
    on_counter_slope,
    place_fault,
    release_fault,
    speed_fault,
    stop_fault,
    volume_fault,
)
from avahazard.records.intake import Intake


def profile(length_m: float) -> Profile:
    """A straight slope of one in two."""
    x = np.array([0.0, length_m])
    return Profile("P", x, 1000.0 - 0.5 * x)


STOP = Event("e", "P", runout_x_m=800.0, runout_sigma_m=10.0)
SPEED = Speed("e", x_m=700.0, elevation_m=None, speed_m_s=20.0, speed_sigma_m_s=2.0)


def faults(intake: Intake) -> list[tuple[str, str]]:
    """File and column of each problem."""
    return [(p.file, p.column) for p in intake.problems]


def test_the_name_of_a_path_is_not_its_id() -> None:
    intake = Intake(records=Records(paths=(Path("P", name="Pra"),), events=(Event("e", "Pra"),)))
    check_references(intake, {"P"}, {"e"})
    assert "such as P, whose name this is" in intake.problems[0].accepted


def test_paths_and_events_must_be_known() -> None:
    intake = Intake(records=Records(events=(STOP,), speeds=(SPEED,)))
    check_references(intake, {"Q"}, {"other"})
    assert [column for _, column in faults(intake)] == ["path_id", "event_id"]
    intake = Intake(records=Records(events=(STOP,), speeds=(SPEED,)))
    check_references(intake, {"P"}, {"e"})
    assert faults(intake) == []


@pytest.mark.parametrize(("length_m", "fault"), [(900.0, False), (600.0, True)])
def test_stored_records_are_checked_on_a_new_profile(length_m: float, fault: bool) -> None:
    known = Records((Path("P"),), (profile(1000.0),), (STOP,), (SPEED,))
    intake = Intake(records=Records(profiles=(profile(length_m),)), known=known)
    check_places(intake)
    expected = [
        ("the database, event e", "runout_x_m"),
        ("the database, a speed of event e", "x_m"),
    ]
    assert faults(intake) == (expected if fault else [])


@pytest.mark.parametrize(
    ("release_m", "fault"), [(900.0, False), (500.0, True), (None, False), (650.0, False)]
)
def test_stored_stops_are_checked_below_a_new_release(release_m: float | None, fault: bool) -> None:
    known = Records((Path("P", release_elevation_m=650.0),), (profile(1000.0),), (STOP,))
    intake = Intake(records=Records((Path("P", release_elevation_m=release_m),)), known=known)
    check_places(intake)
    assert faults(intake) == ([("the database, event e", "runout_x_m")] if fault else [])


def test_a_row_that_replaces_a_stored_one_stands_for_it() -> None:
    known = Records((Path("P"),), (profile(600.0),), (STOP,))
    corrected = Event("e", "P", runout_x_m=500.0, runout_sigma_m=10.0)
    read = Records(events=(corrected,), profiles=(profile(600.0),))
    intake = Intake(records=read, known=known)
    check_places(intake)
    assert faults(intake) == []


BOWL = Profile("P", np.array([0.0, 100, 200, 300, 400]), np.array([900.0, 800, 700, 650, 680]))


@pytest.mark.parametrize(
    ("elevation", "twice"), [(649, False), (650, False), (651, True), (680, True), (681, False)]
)
def test_counter_slope_is_between_lowest_point_and_end(elevation: float, twice: bool) -> None:
    assert on_counter_slope(elevation, BOWL) is twice
    fault = stop_fault(Event("e", "P", runout_elevation_m=elevation, runout_sigma_m=1.0), BOWL)
    assert (fault is not None and "at two places: x = " in str(fault[2])) is twice


@pytest.mark.parametrize(
    ("event", "column"),
    [
        (Event("e", "P", runout_elevation_m=670), "runout_elevation_m"),
        (Event("e", "P", runout_elevation_m=619.9), "runout_elevation_m"),
        (Event("e", "P", runout_elevation_m=930.1), "runout_elevation_m"),
        (Event("e", "P", runout_x_m=431), "runout_x_m"),
        (Event("e", "P", runout_x_m=-31), "runout_x_m"),
    ],
)
def test_stops_that_cannot_be_found(event: Event, column: str) -> None:
    fault = stop_fault(event, BOWL)
    assert fault is not None
    assert fault[0] == column


@pytest.mark.parametrize(
    "event",
    [
        Event("e", "P", runout_elevation_m=670, runout_x_m=350),
        Event("e", "P", runout_elevation_m=620),
        Event("e", "P", runout_x_m=430),
        Event("e", "P", left_profile=True),
        Event("e", "P", left_profile=True, runout_elevation_m=100),
    ],
)
def test_stops_that_can_be_found(event: Event) -> None:
    assert stop_fault(event, BOWL) is None


def test_release_is_on_the_profile_and_above_the_stop() -> None:
    assert release_fault(Path("P", release_elevation_m=900), BOWL) is None
    assert release_fault(Path("P"), BOWL) is None
    for wrong in (
        Path("P", release_elevation_m=931),
        Event("e", "P", release_elevation_m=619, runout_x_m=10),
        Event("e", "P", release_elevation_m=720, runout_elevation_m=751),
    ):
        fault = release_fault(wrong, BOWL)
        assert fault is not None
        assert fault[0] == "release_elevation_m"


def test_speeds_are_on_the_profile() -> None:
    assert speed_fault(Speed("e", 9, 1, x_m=400), BOWL) is None
    assert speed_fault(Speed("e", 9, 1, elevation_m=700), BOWL) is None
    for speed, column in (
        (Speed("e", 9, 1, x_m=401), "x_m"),
        (Speed("e", 9, 1, elevation_m=660), "elevation_m"),
        (Speed("e", 9, 1, elevation_m=1000), "elevation_m"),
    ):
        fault = speed_fault(speed, BOWL)
        assert fault is not None
        assert fault[0] == column


def test_noise_makes_no_counter_slope() -> None:
    """Points of a path that falls all the way rise at many places where they are noisy."""
    rng = np.random.default_rng(8)
    x = np.arange(0.0, 2000.0, 10.0)
    y = 900.0 * np.exp(-x / 500.0) - 0.01 * x
    noisy = Profile("P", x, y + rng.normal(0.0, 5.0, len(x)))
    low = float(noisy.y_m.min())
    for rise in (0.5, 2.0, 5.0):
        assert not on_counter_slope(low + rise, noisy)
        assert stop_fault(Event("e", "P", runout_elevation_m=low + rise), noisy) is None
    # Where it truly rises again, it is refused as before.
    valley = Profile("P", x, y + np.maximum(x - 1500.0, 0.0) * 0.12 + rng.normal(0.0, 5.0, len(x)))
    assert on_counter_slope(float(valley.y_m.min()) + 20.0, valley)


X = np.arange(0.0, 2000.0, 10.0)
FALLING = 1000.0 - 0.3 * X


def hump(height: float) -> Profile:
    """A path that falls by 0.3 and rises on its way, from x = 1000 on, by so many metres."""
    over = np.interp(X, [1000.0, 1100.0, 1200.0], [0.0, height + 30.0, 0.0])
    return Profile("P", X, FALLING + over)


@pytest.mark.parametrize(
    ("elevation", "again"),
    [(650.0, False), (698.0, False), (705.0, True), (730.0, True), (745.0, False)],
)
def test_a_rise_amid_the_path_is_a_counter_slope(elevation: float, again: bool) -> None:
    """From 700 m at x = 1000 to 740 at 1100, and down again to 640 at 1200."""
    profile = hump(40.0)
    assert on_counter_slope(elevation, profile) is again
    event = Event("e", "P", runout_elevation_m=elevation)
    fault = stop_fault(event, profile)
    assert (fault is not None) is again
    assert stop_fault(replace(event, runout_x_m=1090.0), profile) is None
    assert (speed_fault(Speed("e", 20.0, 1.5, elevation_m=elevation), profile) is not None) is again


def test_a_step_lower_than_any_stop_is_known_is_no_counter_slope() -> None:
    assert not any(on_counter_slope(e, hump(8.0)) for e in np.arange(690.0, 720.0, 1.0))
    rough = np.random.default_rng(9).normal(0.0, 5.0, len(X))
    assert not any(on_counter_slope(e, Profile("P", X, FALLING + rough)) for e in FALLING)


SLOPE = Profile("P", np.array([0.0, 500.0, 1000.0]), np.array([1500.0, 1250.0, 1000.0]))
DEPOSIT = {"deposit_length_m": 100.0, "deposit_width_m": 20.0, "deposit_thickness_m": 3.0}


@pytest.mark.parametrize(
    ("volume", "sigma", "fault"),
    [
        (3000.0, 0.5, False),
        (10_000.0, 0.5, False),
        (15_000.0, 0.5, True),
        (500.0, 0.5, True),
        (5000.0, 0.01, False),
        (7000.0, 0.01, True),
        (None, 0.5, False),
    ],
)
def test_volume_and_deposit(volume: float | None, sigma: float, fault: bool) -> None:
    event = Event("e", "P", volume_m3=volume, volume_rel_sigma=sigma, **DEPOSIT)
    assert (volume_fault(event) is not None) is fault


@pytest.mark.parametrize(
    ("event", "column"),
    [
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1100), None),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1140), None),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1200), "runout_elevation_m"),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1200, runout_sigma_m=60), None),
        (Event("e", "P", left_profile=True), None),
        (Event("e", "P", left_profile=True, runout_x_m=990), None),
        (Event("e", "P", left_profile=True, runout_x_m=1200), None),
        (Event("e", "P", left_profile=True, runout_x_m=500), "runout_x_m"),
        (Event("e", "P", left_profile=True, runout_elevation_m=1200), "runout_elevation_m"),
        (Event("e", "P", left_profile=True, runout_elevation_m=900), None),
        (Event("e", "P", runout_x_m=100, release_elevation_m=1300), "runout_x_m"),
        (Event("e", "P", runout_x_m=420, release_elevation_m=1300), None),
        (Event("e", "P", runout_elevation_m=1400, release_elevation_m=1300), "runout_elevation_m"),
        (Event("e", "P", runout_x_m=100), "runout_x_m"),
    ],
)
def test_places(event: Event, column: str | None) -> None:
    found = place_fault(event, Path("P", release_elevation_m=1350), SLOPE)
    assert (found and found[0]) == column


def test_the_top_of_the_profile_is_above_every_stop() -> None:
    assert place_fault(Event("e", "P", runout_x_m=5), Path("P"), SLOPE) is None
    assert place_fault(Event("e", "P", runout_x_m=5), None, SLOPE) is None
