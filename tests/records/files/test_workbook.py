"""Workbooks: several sheets, and cells that must not be misread."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import pytest
from openpyxl import Workbook

from avahazard.records.collection import Records
from avahazard.records.files.conventions import UNKNOWN, Conventions
from avahazard.records.intake import Intake
from avahazard.records.reading import read_files
from tests.records.files.matrix import save_workbook

PROFILE = [("path_id", "x_m", "y_m"), *(("P", 100 * i, 1000 - 90 * i) for i in range(6))]
EVENTS = [("event_id", "path_id", "runout_x_m"), ("a", "P", 300), (7, "P", 310.5)]


def read(file: Path, given: Conventions = UNKNOWN) -> Intake:
    """Read a workbook."""
    return read_files([file], Records(), given=given)


def test_sheets_are_known_by_their_columns_and_others_are_told(tmp_path: Path) -> None:
    sheets = {
        "Profile": PROFILE,
        "Events": EVENTS,
        "velocities": [("event_id", "x_m", "speed_m_s"), ("a", 100, 20)],
        "Notes": [("typed in by", "Anna")],
        "Empty": [],
    }
    found = read(save_workbook(tmp_path / "records.xlsx", sheets))
    assert found.problems == []
    assert [e.event_id for e in found.records.events] == ["a", "7"]
    assert found.records.speeds[0].speed_m_s == 20
    assert len(found.records.profiles[0].x_m) == 6
    assert [line.split(": ")[1].split(",")[0] for line in found.read] == [
        "profiles",
        "events",
        "velocities",
    ]
    (note,) = found.notes
    assert "sheet Notes" in note


def test_the_same_event_in_two_sheets_is_refused(tmp_path: Path) -> None:
    sheets = {"Profile": PROFILE, "1950": EVENTS, "1960": EVENTS}
    found = read(save_workbook(tmp_path / "records.xlsx", sheets))
    assert [(p.line, p.column) for p in found.problems] == [(2, "event_id"), (3, "event_id")]
    assert "sheet 1950, line 2" in found.problems[0].accepted


@pytest.mark.parametrize(
    ("cell", "column", "remedy"),
    [
        ("#N/A", "C", "could not compute"),
        ("=1+2", "C", "open the file in a spreadsheet and save it"),
    ],
)
def test_cells_without_a_value_are_refused(
    tmp_path: Path, cell: str, column: str, remedy: str
) -> None:
    rows = [*EVENTS, ("c", "P", cell)]
    found = read(save_workbook(tmp_path / "records.xlsx", {"p": PROFILE, "e": rows}))
    assert (found.problems[0].line, found.problems[0].column) == (4, column)
    assert remedy in found.problems[0].accepted


def test_a_name_that_became_a_date_is_refused(tmp_path: Path) -> None:
    rows = [EVENTS[0], (dt.date(2024, 3, 1), "P", 300)]
    found = read(save_workbook(tmp_path / "records.xlsx", {"p": PROFILE, "e": rows}))
    assert [(p.line, p.column, p.value) for p in found.problems] == [(2, "event_id", "2024-03-01")]
    assert "spreadsheet holds a date" in found.problems[0].accepted


def test_merged_cells_are_refused(tmp_path: Path) -> None:
    book = Workbook()
    for row in EVENTS:
        book.active.append(row)
    book.active.merge_cells("B2:B3")
    book.save(tmp_path / "events.xlsx")
    found = read(tmp_path / "events.xlsx")
    assert any("not merged" in p.accepted for p in found.problems)


@pytest.mark.parametrize("raw", [b"PK\x03\x04 no archive", b"\xd0\xcf\x11\xe0 an old one"])
def test_what_is_no_workbook_is_refused(tmp_path: Path, raw: bytes) -> None:
    file = tmp_path / "events.xlsx"
    file.write_bytes(raw)
    (problem,) = read(file).problems
    assert ".xlsx without a password" in problem.accepted


def test_content_decides_not_the_ending(tmp_path: Path) -> None:
    save_workbook(tmp_path / "a.xlsx", {"p": PROFILE, "e": EVENTS}).rename(tmp_path / "a.csv")
    assert len(read(tmp_path / "a.csv").records.events) == 2
    (tmp_path / "b.xlsx").write_text("path_id;name\nP;Pra\n")
    assert read(tmp_path / "b.xlsx").records.paths[0].name == "Pra"


def test_numbers_as_text_must_show_their_sign(tmp_path: Path) -> None:
    rows = [("event_id", "path_id", "runout_x_m"), ("a", "P", 300.25), ("b", "P", "1.234")]
    file = save_workbook(tmp_path / "records.xlsx", {"p": PROFILE, "e": rows})
    (problem,) = read(file).problems
    assert (problem.line, problem.value) == (3, "1.234")
    assert read(file, Conventions("point")).problems == []
