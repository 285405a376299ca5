"""Columns beyond those of the forms."""

from __future__ import annotations

import pytest

from avahazard.records.covariates import Kind, column_kinds, read_covariates
from avahazard.records.errors import RowProblem
from avahazard.records.path import Covariate
from avahazard.records.table import table_of


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
    assert column_kinds([{"a": 1.0}, {"b": "x"}]) == {"a": "number", "b": "text"}


def test_a_word_among_numbers_is_refused_and_numbers_among_words_are_told() -> None:
    values, problems = read(["1", "2", "3", "wet"])
    assert values == [1.0, 2.0, 3.0, None]
    assert [(p.line, p.value) for p in problems] == [(5, "wet")]
    rows = [(2 + i, {"id": str(i), "c": text}) for i, text in enumerate(["wet", "dry", "7"])]
    table = table_of("f.csv", ["id", "c"], rows)
    notes: list[str] = []
    read_covariates([table], {"id"}, {}, [], notes)
    assert notes == ["f.csv: c is read as words: line 2 holds 'wet', line 4 7."]
