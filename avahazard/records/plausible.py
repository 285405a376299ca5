"""Numbers that cannot be, and numbers that look like slips of units."""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Collection, Iterator

from avahazard.records.errors import RowProblem
from avahazard.records.forms.meanings import ABOVE_SEA, MEANINGS, Meaning
from avahazard.records.table import Table

YEARS = ("date", "observed_from", "observed_to")
FIRST_YEAR = 1000
SHOWN = 3


def check_ranges(
    table: Table, problems: list[RowProblem], notes: list[str], *, unusual: bool = False
) -> None:
    """Refuse what is physically impossible, and dates to come; note what is unusual, with rows.

    With `unusual` what is possible is usual: flows of another kind than snow, or of another age.
    """
    doubts: list[str] = []
    for column in table.header:
        if column in YEARS:
            _check_years(table, column, problems, doubts)
        elif column in MEANINGS:
            _check_numbers(table, column, MEANINGS[column], problems, doubts)
    if not unusual:
        notes += doubts


def _check_numbers(
    table: Table, column: str, meaning: Meaning, problems: list[RowProblem], notes: list[str]
) -> None:
    if meaning.limits is None:
        return
    (first, last), (low, high) = meaning.limits
    unit = "m" if meaning.unit == ABOVE_SEA else meaning.unit
    unusual: list[tuple[int, str]] = []
    for k, text, value in _outside(table, column, low, high):
        if first <= value <= last:
            unusual.append((table.lines[k], text))
        elif value > 0 or first < 0 or meaning.further:  # a row's form refuses what is not over 0
            accepted = f"a number from {first:g} to {last:g} {unit}".rstrip()
            problems.append(RowProblem(table.file, table.lines[k], column, text, accepted))
    if unusual:
        notes.append(_note(table, column, unusual, f"outside {low:g} to {high:g} {unit}".rstrip()))


def _check_years(table: Table, column: str, problems: list[RowProblem], notes: list[str]) -> None:
    # A day's grace: the clock may stand in another time zone.
    tomorrow = (dt.date.today() + dt.timedelta(1)).isoformat()
    unusual: list[tuple[int, str]] = []
    odd = {
        text
        for text in table.counts(column)
        if len(text) in (4, 10)
        and text[:4].isdigit()
        and (text > tomorrow[: len(text)] or int(text[:4]) < FIRST_YEAR)
    }
    for k, text in _rows_with(table, column, odd):
        if text > tomorrow[: len(text)]:
            accepted = "a date that is not to come"
            problems.append(RowProblem(table.file, table.lines[k], column, text, accepted))
        else:
            unusual.append((table.lines[k], text))
    if unusual:
        notes.append(_note(table, column, unusual, f"before the year {FIRST_YEAR}"))


def _outside(
    table: Table, column: str, low: float, high: float
) -> Iterator[tuple[int, str, float]]:
    """The numbers of a column that are not from `low` to `high`, with their rows from 0."""
    numbers = {text: _number(text) for text in table.counts(column)}
    odd = {text: x for text, x in numbers.items() if x is not None and not low <= x <= high}
    for k, text in _rows_with(table, column, odd):
        yield k, text, odd[text]


def _rows_with(table: Table, column: str, texts: Collection[str]) -> Iterator[tuple[int, str]]:
    """The rows from 0 whose text is one of these, of which there are few or none."""
    return ((k, text) for k, text in table.values(column) if text in texts) if texts else iter(())


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _note(table: Table, column: str, rows: list[tuple[int, str]], what: str) -> str:
    shown = ", ".join(f"line {line}: {text}" for line, text in rows[:SHOWN])
    more = f" and {len(rows) - SHOWN} more" if len(rows) > SHOWN else ""
    return (
        f"{table.file}: {column} {what} ({shown}{more}). Are the unit and the "
        "value right? If so, --unusual says it."
    )
