"""Lines of cells, held by column, against the lines themselves."""

from __future__ import annotations

import datetime as dt
from pathlib import Path
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openpyxl import Workbook

from avahazard.records.collection import Records
from avahazard.records.conventions import UNKNOWN, Conventions
from avahazard.records.errors import RowProblem
from avahazard.records.intake import Intake
from avahazard.records.reading import read_files
from avahazard.records.table import LOOKED_AT, FileTable, Line, filled, header_row, table_of
from tests.records.matrix import save_workbook

WORDS = st.sampled_from(["", "", "7", "17.25", "1950-02-13", "a text of more than 15 bytes: ⛰"])
HEADERS = st.lists(st.sampled_from(["a", "b", "c", "d", ""]), min_size=1, max_size=5).filter(
    lambda names: any(names) and len({n for n in names if n}) == len([n for n in names if n])
)
LINES = st.lists(st.lists(WORDS, max_size=7), max_size=12)


def obvious(
    header: list[str], lines: list[Line]
) -> tuple[list[tuple[int, dict[str, str]]], list[int], set[int]]:
    """Rows with their lines, lines of another length, and columns without a name, one by one."""
    last = max(k for k, name in enumerate(header) if name)
    rows, uneven = [], []
    nameless = set()
    for line, cells in lines:
        filled = [k for k, text in enumerate(cells) if text]
        nameless |= {k for k in filled if k < len(header) and not header[k]}
        if len(cells) <= last or (filled and filled[-1] >= len(header)):
            uneven.append(line)
        else:
            rows.append((line, {header[k]: cells[k] for k in filled}))
    return rows, uneven, nameless


@given(HEADERS, LINES)
def test_columns_hold_what_the_lines_hold(header: list[str], cells: list[list[str]]) -> None:
    lines: list[Line] = [(3 + 2 * k, row) for k, row in enumerate(cells) if any(row)]
    rows, uneven, nameless = obvious(header, lines)
    with patch("avahazard.records.table.AT_ONCE", 3):
        problems: list[RowProblem] = []
        table = filled(FileTable("a.csv"), [(1, header), *lines], problems)
        a_title = header_row([(1, header), *lines][:LOOKED_AT]) > 0
        if nameless or (a_title and sum(map(bool, header)) < 2):  # a title is no header
            assert table is None
            assert a_title or len(problems) == len(nameless)
            return
        assert table is not None
        assert [problem.line for problem in problems] == uneven
        assert list(table.numbered()) == rows
        wanted = range(len(rows) - 1, -1, -2)
        assert list(table.at(wanted)) == [rows[k] for k in wanted]
        for name in filter(None, header):
            texts = [row.get(name, "") for _, row in rows]
            assert [text for block in table.blocks(name) for text in block] == texts
            assert list(table.values(name)) == [(k, t) for k, t in enumerate(texts) if t]
            some = [(line, {name: row[name]} if name in row else {}) for line, row in rows]
            assert list(table.numbered([name])) == some
        again = table_of("a.csv", table.header, rows)
        assert list(again.numbered()) == rows


def test_a_file_without_a_line_has_no_cells() -> None:
    assert filled(FileTable("a.csv"), [], []) is None


@given(HEADERS)
def test_a_header_alone_has_columns_of_no_rows(header: list[str]) -> None:
    table = filled(FileTable("a.csv"), [(1, header)], [])
    assert table is not None
    assert {name: len(column.texts) for name, column in table.columns.items()} == {
        name: 0 for name in header if name
    }


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


@pytest.mark.parametrize(
    ("raw", "accepted"),
    [
        (b"PK\x03\x04 no archive", "this file is damaged"),
        (b"XK\x03\x04\x81 no archive", "this file is damaged"),
        (b"\xd0\xcf\x11\xe0 an old one", "(.xlsx, .xls, .ods) without a password"),
    ],
)
def test_what_is_no_workbook_is_refused(tmp_path: Path, raw: bytes, accepted: str) -> None:
    file = tmp_path / "events.xlsx"
    file.write_bytes(raw)
    (problem,) = read(file).problems
    assert accepted in problem.accepted


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


def test_hidden_rows_and_sheets_are_said(tmp_path: Path) -> None:
    book = Workbook()
    first, second = book.worksheets[0], book.create_sheet("old")
    for sheet, name in ((first, "a"), (second, "b")):
        sheet.append(["event_id", "fall_height_m", "runout_length_m"])
        sheet.append([f"{name}1", 500.0, 1200.0])
    first.row_dimensions[2].hidden = True
    second.sheet_state = "hidden"
    book.save(tmp_path / "events.xlsx")
    one, other = read(tmp_path / "events.xlsx").read
    assert "1 hidden rows among them" in one
    assert "a hidden sheet" in other
