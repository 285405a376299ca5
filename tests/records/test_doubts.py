"""Avalanches that may be recorded twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.notes import grouped
from avahazard.records.collection import Event
from avahazard.records.crosscheck import dwarfing, repeated, spelled_variously

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
    found = repeated([event, third, again])
    assert [note.of for note in found] == ([("a = b",)] if alike else [])


def test_each_group_has_a_note() -> None:
    assert repeated([]) == []
    (note,) = repeated([replace(FIRST, event_id=event_id) for event_id in "abc"])
    assert note.startswith("a = b = c: alike in path, day and stop")
    pairs = [replace(FIRST, path_id=f"P{k}", event_id=f"{x}{k}") for k in range(6) for x in "ab"]
    (one,) = grouped(repeated(pairs))
    assert one.startswith("a0 = b0, a1 = b1, a2 = b2 and 3 more: alike")
    assert [note.of for note in repeated(pairs, new={"b3", "c"})] == [("a3 = b3",)]


USUAL = [1e3, 2e4, 1e5, 3e5, 8e5]


@pytest.mark.parametrize(
    ("volumes", "found"),
    [
        (USUAL, []),
        ([*USUAL, 8e8], [5]),
        ([8e8, *USUAL], [0]),
        ([*USUAL, 5e7], []),
        ([*USUAL, 8e8, 9e8], []),  # two of seven are no slips
        ([*USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, 9e8, 8e8], [40, 41]),
        ([1e3, np.nan, 8e8], []),
        ([*USUAL, np.nan], []),
    ],
)
def test_a_few_beyond_a_gap(volumes: list[float], found: list[int]) -> None:
    assert dwarfing(np.log(np.array(volumes))).tolist() == found


def test_values_that_differ_in_spelling_alone_are_named() -> None:
    texts = ["wet", "Wet", "wet", "dry", "WET"]
    events = [replace(FIRST, event_id=str(k), covariates={"snow": t}) for k, t in enumerate(texts)]
    (note,) = spelled_variously(events)
    assert str(note) == "snow: spellings that are taken for one value: wet (WET, Wet)."
    assert spelled_variously(events[2:4]) == []
