"""Avalanches that may be written down twice."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.records.event import Event
from avahazard.records.repeated import repeated, repeated_notes

FIRST = Event(
    "a", "P", "1951-01-20", runout_elevation_m=1300.0, volume_m3=5e3, covariates={"snow": "wet"}
)
YEAR = replace(FIRST, date="1951")
LENGTH = Event("a", fall_height_m=640.0, runout_length_m=1450.0, volume_m3=2e6)


@pytest.mark.parametrize(
    ("event", "other", "alike"),
    [
        (FIRST, {}, True),
        (FIRST, {"volume_m3": 4e3, "covariates": {}}, True),  # another list, other columns
        (FIRST, {"volume_m3": None}, True),
        (FIRST, {"date": "1951-01-21"}, False),
        (FIRST, {"path_id": "Q"}, False),
        (FIRST, {"runout_elevation_m": 1301.0}, False),
        (YEAR, {}, True),
        (YEAR, {"volume_m3": 4e3}, False),  # two of a year at one rounded place
        (YEAR, {"covariates": {"snow": "dry"}}, False),
        (replace(YEAR, volume_m3=None), {}, False),
        (replace(FIRST, runout_elevation_m=None, left_profile=True), {}, False),
        (LENGTH, {}, True),
        (LENGTH, {"runout_length_m": 1460.0}, False),
    ],
)
def test_what_is_one_avalanche_twice(event: Event, other: dict[str, object], alike: bool) -> None:
    again = replace(event, event_id="b", **other)  # type: ignore[arg-type]
    third = replace(event, event_id="c", path_id="R", runout_elevation_m=900.0)
    assert repeated([event, third, again]) == ([("a", "b")] if alike else [])


def test_a_few_are_shown() -> None:
    assert repeated_notes([]) == []
    (note,) = repeated_notes([("a", "b", "c")])
    assert note.startswith("events a = b = c are alike")
    pairs = [(f"a{k}", f"b{k}") for k in range(6)]
    assert repeated_notes(pairs)[-1] == "3 more avalanches may be written down twice."
    assert repeated_notes(pairs[:4])[-1] == "1 more avalanche may be written down twice."
