"""Forms known by their headers."""

from __future__ import annotations

import datetime as dt

import pytest

from avahazard.records.collection import Covariate, Event, Path
from avahazard.records.errors import RowProblem
from avahazard.records.forms import Kind, check_ranges, column_kinds, read_covariates, recognise
from avahazard.records.meanings import MEANINGS, Meaning
from avahazard.records.table import table_of


@pytest.mark.parametrize(
    ("header", "name", "kind"),
    [
        ("path_id,name", "x.csv", "paths"),
        ("path_id,x_m,y_m", "x.csv", "profiles"),
        ("path_id,x_m,y_m", "paths.csv", "profiles"),
        ("path_id,x_m", "paths.csv", "paths"),
        ("event_id,path_id,runout_x_m", "profiles.csv", "events"),
        ("event_id,fall_height_m,runout_length_m", "x.csv", "events"),
        ("event_id,h_over_l", "x.csv", "events"),
        ("event_id,x_m,speed_m_s", "events.csv", "velocities"),
        ("event_id,elevation_m,speed_m_s", "x.csv", "velocities"),
    ],
)
def test_kind_by_header(header: str, name: str, kind: str) -> None:
    problems: list[RowProblem] = []
    assert recognise(table_of(name, header.split(","), []), problems) == kind
    assert not problems


@pytest.mark.parametrize(
    ("header", "name", "columns"),
    [
        ("path_id,x_m", "profiles.csv", ["y_m"]),
        ("path_id", "profiles.csv", ["x_m", "y_m"]),
        ("name", "paths.csv", ["path_id"]),
        ("event_id,path_id", "x.csv", ["runout_x_m"]),
        ("event_id,fall_height_m", "x.csv", ["runout_length_m"]),
        ("event_id,x_m", "velocities.csv", ["speed_m_s"]),
        ("event_id,speed_m_s", "x.csv", ["x_m"]),
        ("date", "x.csv", [""]),
    ],
)
def test_missing_columns_are_named(header: str, name: str, columns: list[str]) -> None:
    problems: list[RowProblem] = []
    assert recognise(table_of(name, header.split(","), []), problems) is None
    assert [p.column for p in problems] == columns


def test_events_to_predict_need_no_runout() -> None:
    problems: list[RowProblem] = []
    table = table_of("x.csv", ["event_id", "path_id"], [])
    assert recognise(table, problems, need_runout=False) == "events"


def read(
    texts: list[str], stored: dict[str, Kind] | None = None
) -> tuple[list[Covariate | None], list[RowProblem]]:
    """Read a column `c` beside a column of ids; an empty text is a missing value."""
    rows = [(2 + i, {"id": str(i), "c": text}) for i, text in enumerate(texts)]
    table = table_of("f.csv", ["id", "c"], rows)
    problems: list[RowProblem] = []
    found = read_covariates([table], {"id"}, stored or {}, problems, [])
    return [found["f.csv", line].get("c") for line in table.lines], problems


@pytest.mark.parametrize(
    ("texts", "values"),
    [
        (["1", "", "-2.5e3"], [1.0, None, -2500.0]),
        (["1", "wet", ""], ["1", "wet", None]),
        (["1_0", "2"], ["1_0", "2"]),
        (["", ""], [None, None]),
    ],
)
def test_numbers_where_every_value_is_one(texts: list[str], values: list[Covariate | None]) -> None:
    assert read(texts) == (values, [])


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e999", "1e31"])
def test_numbers_have_to_be_finite(text: str) -> None:
    _, problems = read(["1", text])
    assert [(p.line, p.column, p.value) for p in problems] == [(3, "c", text)]


def test_stored_kind_decides() -> None:
    assert read(["1"], {"c": "text"}) == (["1"], [])
    values, problems = read(["1", "wet"], {"c": "number"})
    assert values == [1.0, None]
    assert [p.value for p in problems] == ["wet"]


def test_a_known_column_of_numbers_holds_no_words_even_where_all_are_words() -> None:
    table = table_of("f.csv", ["id", "width_m"], [(2, {"id": "1", "width_m": "broad"})])
    problems: list[RowProblem] = []
    assert read_covariates([table], {"id"}, {}, problems, []) == {("f.csv", 2): {}}
    (problem,) = problems
    assert (problem.line, problem.column) == (2, "width_m")
    assert "as most of the column" not in problem.accepted


def test_kinds_of_stored_records() -> None:
    assert column_kinds([Path("P", covariates={"a": 1.0}), Event("e", covariates={"b": "x"})]) == {
        "a": "number",
        "b": "text",
    }


def test_a_word_among_numbers_is_refused_and_numbers_among_words_are_told() -> None:
    values, problems = read(["1", "2", "3", "wet"])
    assert values == [1.0, 2.0, 3.0, None]
    assert [(p.line, p.value) for p in problems] == [(5, "wet")]
    rows = [(2 + i, {"id": str(i), "c": text}) for i, text in enumerate(["wet", "dry", "7"])]
    table = table_of("f.csv", ["id", "c"], rows)
    notes: list[str] = []
    read_covariates([table], {"id"}, {}, [], notes)
    assert notes == ["f.csv: c is read as words: line 2 holds 'wet', line 4 7."]


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
    depth = Meaning("depth", "m", (0.0, 100.0), (0.0, 20.0), further=("events",))
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
