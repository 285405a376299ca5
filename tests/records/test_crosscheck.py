"""Records against each other, those of the database included."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.collection import Records
from avahazard.records.crosscheck import check_places, check_references
from avahazard.records.event import Event, Speed
from avahazard.records.intake import Intake
from avahazard.records.path import Path, Profile


def profile(length_m: float) -> Profile:
    """A straight slope of one in two."""
    x = np.array([0.0, length_m])
    return Profile("P", x, 1000.0 - 0.5 * x)


STOP = Event("e", "P", runout_x_m=800.0, runout_sigma_m=10.0)
SPEED = Speed("e", x_m=700.0, elevation_m=None, speed_m_s=20.0, speed_sigma_m_s=2.0)


def faults(intake: Intake) -> list[tuple[str, str]]:
    """File and column of each problem."""
    return [(p.file, p.column) for p in intake.problems]


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
    intake = Intake(records=Records(profiles=(profile(length_m),)))
    check_places(intake, known)
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
    intake = Intake(records=Records((Path("P", release_elevation_m=release_m),)))
    check_places(intake, known)
    assert faults(intake) == ([("the database, event e", "runout_x_m")] if fault else [])


def test_a_row_that_replaces_a_stored_one_stands_for_it() -> None:
    known = Records((Path("P"),), (profile(600.0),), (STOP,))
    corrected = Event("e", "P", runout_x_m=500.0, runout_sigma_m=10.0)
    intake = Intake(records=Records(events=(corrected,), profiles=(profile(600.0),)))
    check_places(intake, known)
    assert faults(intake) == []
