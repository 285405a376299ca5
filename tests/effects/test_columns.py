"""Columns over events."""

from __future__ import annotations

from datetime import date, timedelta

import numpy as np
import pytest

from avahazard.effects.columns import MADE, NEARBY_DAYS, build_columns, counted
from avahazard.records.collection import Event, Path

PATHS = {
    "P": Path("P", section="open", covariates={"aspect": 45.0, "zone": "north"}),
    "Q": Path("Q", covariates={"aspect": 90.0}),
}
EVENTS = (
    Event("a", "Q", "1950-02-13", volume_m3=1e4, covariates={"wind": 3.0, "snow_type": "wet"}),
    Event("b", "P", "1999", runout_elevation_m=810.0, covariates={"wind": "calm", "zone": "x"}),
    Event("c", fall_height_m=500.0, runout_length_m=900.0, deposit_length_m=70.0),
    Event("d", "Q", "1951-11-01", covariates={"aspect": 10.0}),
)


def _columns():
    return build_columns(EVENTS, PATHS, np.array([1800.0, 1700.0, np.nan, 1800.0]))


def test_events_point_to_their_paths_in_the_order_met() -> None:
    columns = _columns()
    assert len(columns) == 4
    assert columns.event_id == ("a", "b", "c", "d")
    assert columns.paths == ("Q", "P")
    assert columns.path_index.tolist() == [0, 1, -1, 0]
    assert columns.section.tolist() == ["", "open", "", ""]


def test_what_is_missing_is_nan() -> None:
    columns = _columns()
    nan = np.nan
    for got, expected in (
        (columns.year, [1950.0, 1999.0, nan, 1951.0]),
        (columns.log_volume, [np.log(1e4), nan, nan, nan]),
        (columns.deposit_length, [nan, nan, 70.0, nan]),
        (columns.stop_elevation, [nan, 810.0, nan, nan]),
        (columns.release_elevation, [1800.0, 1700.0, nan, 1800.0]),
    ):
        assert got == pytest.approx(np.array(expected), nan_ok=True)


@pytest.mark.parametrize(
    ("date", "day"),
    [
        ("1950-11-01", 0.0),
        ("1950-10-31", 364.0),
        ("1951-01-01", 61.0),
        ("1952-03-01", 121.0),  # a leap year
        ("1951-03-01", 120.0),
        ("1951", np.nan),
        (None, np.nan),
    ],
)
def test_days_of_the_winter_count_from_november(date: str | None, day: float) -> None:
    columns = build_columns((Event("a", date=date),), {}, np.array([np.nan]))
    assert columns.day_of_winter[0] == pytest.approx(day, nan_ok=True)


def test_covariates_of_events_go_before_those_of_their_paths() -> None:
    columns = _columns()
    assert columns.numbers.keys() == {"aspect", "aspect_north", "aspect_east", "fall_height_m"}
    assert columns.numbers["aspect"] == pytest.approx([90.0, 45.0, np.nan, 10.0], nan_ok=True)
    assert columns.texts["zone"].tolist() == ["", "x", "", ""]
    assert columns.texts["snow_type"].tolist() == ["wet", "", "", ""]


def test_what_the_form_of_a_path_has_is_a_column() -> None:
    paths = {
        "P": Path("P", orientation="NE", catchment_ha=12.0, covariates={"eastness": 0.5}),
        "Q": Path("Q", orientation="south"),
    }
    columns = build_columns(EVENTS, paths, np.full(4, 1800.0))
    assert columns.texts["orientation"].tolist() == ["south", "NE", "", "south"]
    nan = np.nan
    for name, expected in (
        ("northness", [nan, 0.707, nan, nan]),
        ("eastness", [nan, 0.5, nan, nan]),  # a column of that name goes before what is made
        ("catchment_ha", [nan, 12.0, nan, nan]),
    ):
        assert columns.numbers[name] == pytest.approx(expected, nan_ok=True)
    facing = [_northness(wind) for wind in ("N", "ssw", "NNW", "W")]
    assert facing == pytest.approx(np.cos(np.radians([0.0, 202.5, 337.5, 270.0])), abs=1e-3)


def _northness(wind: str) -> float:
    (event,) = (Event("a", "P"),)
    columns = build_columns((event,), {"P": Path("P", orientation=wind)}, np.array([1800.0]))
    return float(columns.numbers["northness"][0])


def test_a_direction_is_north_and_east_too() -> None:
    degrees = {"wind_dir_deg": 135.0, "Windrichtung": "SE", "direction": "variable", "dirt": 9.0}
    degrees |= {"aspect_deg": 90.0, "aspect_deg_east": 0.9}
    events = (Event("a", covariates=degrees), Event("b", covariates={"direction": "w"}))
    columns = build_columns(events, {}, np.full(2, np.nan))
    nan = np.nan
    for name, expected in (
        ("wind_dir_deg_north", [-(0.5**0.5), nan]),
        ("wind_dir_deg_east", [0.5**0.5, nan]),
        ("Windrichtung_north", [-(0.5**0.5), nan]),
        ("direction_east", [nan, -1.0]),
        ("aspect_deg_north", [0.0, nan]),
        ("aspect_deg_east", [0.9, nan]),  # of the file
    ):
        assert columns.numbers[name] == pytest.approx(expected, nan_ok=True)
    assert not {"dirt_north", "aspect_deg_east_north"} & columns.numbers.keys()


def test_a_column_with_one_word_is_all_words() -> None:
    assert _columns().texts["wind"].tolist() == ["3.0", "calm", "", ""]


def test_the_fall_height_of_an_event_without_a_profile_is_a_column() -> None:
    columns = _columns()
    assert columns.numbers["fall_height_m"] == pytest.approx(
        [np.nan, np.nan, 500.0, np.nan], nan_ok=True
    )


def test_what_the_records_count_is_what_one_counts_by_hand() -> None:
    rng = np.random.default_rng(11)
    paths = {f"P{k}": Path(f"P{k}", location=("north", "south")[k // 2]) for k in range(4)}
    events = []
    for k in range(60):
        day = date(1990, 9, 25) + timedelta(int(rng.integers(0, 900)))
        events.append(
            Event(
                f"e{k}",
                f"P{rng.integers(4)}",
                str(day) if k % 7 else "1991",
                volume_m3=float(rng.lognormal(9.0, 1.0)) if k % 5 else None,
            )
        )
    events.append(Event("straight", date="1991-01-05", fall_height_m=500.0, runout_length_m=900.0))
    columns = build_columns(events, paths, np.full(len(events), np.nan))
    made = counted(columns, columns)
    assert tuple(made) == MADE

    def winter_of(day: date) -> int:
        return day.year + (day.month >= 10)

    for i, event in enumerate(events):
        found = {name: float(made[name][i]) for name in MADE}
        if event.date == "1991":
            assert all(np.isnan(v) for v in found.values())
            continue
        day, order, last, nearby, volume = date.fromisoformat(event.date), 1, None, 0, 0.0
        for other in events:
            if other is event or other.date == "1991":
                continue
            its = date.fromisoformat(other.date)
            location = paths[other.path_id].location if other.path_id else ""
            selected = paths[event.path_id].location if event.path_id else ""
            nearby += location == selected and abs((its - day).days) <= NEARBY_DAYS
            same = event.path_id is not None and other.path_id == event.path_id
            if same and winter_of(its) == winter_of(day) and its < day:
                order += 1
                last = max(its, last or its)
                volume += other.volume_m3 or 0.0
        expected = {
            "order_in_winter": order if event.path_id else np.nan,
            "days_since_last": (day - last).days if last else np.nan,
            "avalanches_nearby": nearby,
            "volume_in_winter": np.log(volume) if volume else np.nan,
        }
        assert found == pytest.approx(expected, nan_ok=True)
