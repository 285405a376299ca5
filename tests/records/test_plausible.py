"""Numbers that cannot be, and numbers that look like slips of units."""

from __future__ import annotations

import datetime as dt

import pytest

from avahazard.records.errors import RowProblem
from avahazard.records.forms.meanings import MEANINGS, Limits, Meaning
from avahazard.records.plausible import check_ranges
from avahazard.records.table import table_of


def check(column: str, text: str) -> tuple[list[RowProblem], list[str]]:
    """Check a column of two rows, the first an ordinary one."""
    table = table_of("f.csv", [column], [(2, {column: "1"}), (3, {column: text})])
    problems: list[RowProblem] = []
    notes: list[str] = []
    check_ranges(table, problems, notes)
    return problems, notes


@pytest.mark.parametrize(
    ("column", "text"),
    [
        ("volume_m3", "1e-320"),
        ("volume_m3", "1e308"),
        ("runout_sigma_m", "1e15"),
        ("volume_rel_sigma", "50"),
        ("speed_m_s", "1e20"),
        ("y_m", "12000"),
        ("x_m", "1e9"),
        ("fall_height_m", "30000"),
        ("fall_height_m", "1e-320"),
        ("runout_length_m", "5e-324"),
        ("h_over_l", "1e-9"),
        ("h_over_l", "1e5"),
        ("date", "9000"),
        ("date", "2999-01-01"),
        ("observed_to", "2999"),
    ],
)
def test_the_impossible_is_refused_with_its_row(column: str, text: str) -> None:
    problems, notes = check(column, text)
    assert [(p.line, p.column, p.value) for p in problems] == [(3, column, text)]
    assert notes == []


@pytest.mark.parametrize(
    ("column", "text"),
    [
        ("volume_m3", "0.1"),
        ("volume_m3", "2e13"),
        ("speed_m_s", "180"),
        ("runout_length_m", "0.5"),
        ("h_over_l", "20"),
        ("volume_rel_sigma", "4"),
        ("runout_sigma_m", "3000"),
        ("date", "0563"),
    ],
)
def test_the_doubtful_is_noted_with_its_row(column: str, text: str) -> None:
    problems, notes = check(column, text)
    assert problems == []
    (note,) = notes
    assert f"line 3: {text}" in note


@pytest.mark.parametrize(
    ("column", "text"),
    [("volume_m3", "50000"), ("volume_m3", "word"), ("volume_m3", "nan"), ("date", "1950-02-13")],
)
def test_the_rest_passes_or_is_for_the_form(column: str, text: str) -> None:
    assert check(column, text) == ([], [])


def test_a_further_column_has_its_limits_from_its_meaning_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    depth = Meaning("depth", "m", "number", Limits((0.0, 100.0), (0.0, 20.0)), ("events",))
    monkeypatch.setitem(MEANINGS, "deposit_depth_m", depth)
    (problem,), _ = check("deposit_depth_m", "-1")
    assert problem.accepted == "a number from 0 to 100 m"
    _, (note,) = check("deposit_depth_m", "30")
    assert "outside 0 to 20 m" in note


def test_what_is_meant_so_needs_no_note_and_stays_within_what_is_possible() -> None:
    rows = [(2, {"volume_m3": "2e13"}), (3, {"volume_m3": "1e16"})]
    table = table_of("f.csv", ["volume_m3"], rows)
    problems: list[RowProblem] = []
    notes: list[str] = []
    check_ranges(table, problems, notes, unusual=True)
    assert notes == []
    assert [p.line for p in problems] == [3]


def test_today_is_no_date_to_come() -> None:
    assert check("date", dt.date.today().isoformat()) == ([], [])
    assert check("date", str(dt.date.today().year)) == ([], [])


def test_many_doubtful_rows_are_one_note() -> None:
    rows = [(line, {"volume_m3": "5e9"}) for line in range(2, 22)]
    table = table_of("f.csv", ["volume_m3"], rows)
    notes: list[str] = []
    check_ranges(table, [], notes)
    assert len(notes) == 1
    assert "and 17 more" in notes[0]
