"""Read records against stored ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.records.collection import Event, Path, Profile, Records, Speed
from avahazard.records.intake import (
    Count,
    Intake,
    differences,
    merge_records,
    profile_difference,
    speed_key,
)

STORED = Records(
    (Path("P"), Path("Q", name="Quarry")),
    (Profile("P", np.arange(5.0), -np.arange(5.0)),),
    (Event("e", "P", runout_x_m=3.0), Event("f", "P", runout_x_m=4.0, volume_m3=10.0)),
    (Speed("e", 9.0, 1.0, x_m=1.0),),
)


def intake(records: Records, known: Records = STORED) -> Intake:
    """Return `records` as if each had been read from its own line."""
    keys = [
        *(("path", p.path_id) for p in records.paths),
        *(("profile", p.path_id) for p in records.profiles),
        *(("event", e.event_id) for e in records.events),
        *(speed_key(s) for s in records.speeds),
    ]
    origins = {key: ("f", line) for line, key in enumerate(keys, start=2)}
    return Intake(["f"], records, origins, known=known)


def test_the_same_again_is_no_change() -> None:
    read = intake(STORED)
    write, counts = merge_records(read)
    assert not read.problems
    assert write == Records()
    assert counts == {
        "paths": Count(unchanged=2),
        "profiles": Count(unchanged=1),
        "events": Count(unchanged=2),
        "speeds": Count(unchanged=1),
    }


def test_new_records_are_written() -> None:
    write, counts = merge_records(intake(STORED, Records()))
    assert write == STORED
    assert counts["events"] == Count(new=2)


CHANGED = Records(
    (Path("Q", name="Quarry", section="open"),),
    (Profile("P", np.arange(5.0), np.array([0, -1, -2, -3, -4.5])),),
    (Event("f", "P", runout_x_m=4.5),),
    (Speed("e", 9.5, 1.0, x_m=1.0),),
)


def test_contradictions_are_listed_with_the_stored_value() -> None:
    read = intake(CHANGED)
    write, _ = merge_records(read)
    assert write == Records()
    assert [(p.line, p.column, p.value) for p in read.problems] == [
        (2, "section", "open"),
        (3, "y_m", "-4.5"),
        (4, "runout_x_m", "4.5"),
        (4, "volume_m3", ""),
        (5, "speed_m_s", "9.5"),
    ]
    assert read.problems[2].accepted == "4.0, as stored before, or --update"


def test_update_replaces_whole_records() -> None:
    read = intake(CHANGED)
    write, counts = merge_records(read, update=True)
    assert not read.problems
    assert write == CHANGED
    assert all(count == Count(updated=1) for count in counts.values())


def test_a_bare_path_takes_its_row_without_update() -> None:
    read = intake(Records((replace(STORED.paths[0], name="Name"),)))
    _, counts = merge_records(read)
    assert not read.problems
    assert counts["paths"] == Count(updated=1)


EVENT = Event("e", "P", runout_x_m=0.1 + 0.2, covariates={"a": 1.0})
PROFILE = Profile("P", np.arange(5.0), -np.arange(5.0), crs="A", lon=np.ones(5), lat=np.ones(5))


def test_numbers_are_compared_to_the_last_bit() -> None:
    assert differences(EVENT, replace(EVENT)) == []
    assert differences(EVENT, replace(EVENT, runout_x_m=0.3)) == [("runout_x_m", 0.1 + 0.2, 0.3)]


def test_covariates_are_compared_by_column() -> None:
    other = replace(EVENT, covariates={"b": "x"})
    assert differences(EVENT, other) == [("a", 1.0, None), ("b", None, "x")]


@pytest.mark.parametrize(
    ("other", "place", "column"),
    [
        (replace(PROFILE, y_m=np.array([0, -1, -2.5, -3, -4])), 2, "y_m"),
        (replace(PROFILE, crs="B"), 0, "crs"),
        (replace(PROFILE, lon=None), 0, "lon"),
        (replace(PROFILE, land_cover=("open",) * 5), 0, "land_cover"),
        (
            Profile("P", np.arange(4.0), -np.arange(4.0), crs="A", lon=np.ones(4), lat=np.ones(4)),
            3,
            "path_id",
        ),
    ],
)
def test_the_first_different_point_is_found(other: Profile, place: int, column: str) -> None:
    found = profile_difference(PROFILE, other)
    assert found is not None
    assert (found[0], found[1][0]) == (place, column)


def test_equal_profiles() -> None:
    assert profile_difference(PROFILE, replace(PROFILE, y_m=PROFILE.y_m.copy())) is None
