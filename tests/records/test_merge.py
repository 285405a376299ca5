"""Read records against stored ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.intake import Intake, speed_key
from avahazard.records.merge import Count, merge_records
from avahazard.records.path import Path, Profile

STORED = Records(
    (Path("P"), Path("Q", name="Quarry")),
    (Profile("P", np.arange(5.0), -np.arange(5.0)),),
    (Event("e", "P", runout_x_m=3.0), Event("f", "P", runout_x_m=4.0, volume_m3=10.0)),
    (Speed("e", 9.0, 1.0, x_m=1.0),),
)


def intake(records: Records) -> Intake:
    """Return `records` as if each had been read from its own line."""
    keys = [
        *(("path", p.path_id) for p in records.paths),
        *(("profile", p.path_id) for p in records.profiles),
        *(("event", e.event_id) for e in records.events),
        *(speed_key(s) for s in records.speeds),
    ]
    return Intake(["f"], records, {key: ("f", line) for line, key in enumerate(keys, start=2)})


def test_the_same_again_is_no_change() -> None:
    read = intake(STORED)
    merge = merge_records(read, STORED)
    assert not read.problems
    assert merge.write == Records()
    assert merge.counts == {
        "paths": Count(unchanged=2),
        "profiles": Count(unchanged=1),
        "events": Count(unchanged=2),
        "speeds": Count(unchanged=1),
    }


def test_new_records_are_written() -> None:
    merge = merge_records(intake(STORED), Records())
    assert merge.write == STORED
    assert merge.counts["events"] == Count(new=2)


CHANGED = Records(
    (Path("Q", name="Quarry", section="open"),),
    (Profile("P", np.arange(5.0), np.array([0, -1, -2, -3, -4.5])),),
    (Event("f", "P", runout_x_m=4.5),),
    (Speed("e", 9.5, 1.0, x_m=1.0),),
)


def test_contradictions_are_listed_with_the_stored_value() -> None:
    read = intake(CHANGED)
    merge = merge_records(read, STORED)
    assert merge.write == Records()
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
    merge = merge_records(read, STORED, update=True)
    assert not read.problems
    assert merge.write == CHANGED
    assert all(count == Count(updated=1) for count in merge.counts.values())


def test_a_bare_path_takes_its_row_without_update() -> None:
    read = intake(Records((replace(STORED.paths[0], name="Name"),)))
    merge = merge_records(read, STORED)
    assert not read.problems
    assert merge.counts["paths"] == Count(updated=1)
