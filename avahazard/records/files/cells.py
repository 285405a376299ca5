"""The cells of a table as plain numbers and ISO dates, or refused where they are ambiguous."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from avahazard.records.errors import RowProblem
from avahazard.records.files.conventions import Conventions
from avahazard.records.files.dates import read_dates
from avahazard.records.files.numbers import Decimal, Evidence, canonical, is_number, weigh
from avahazard.records.forms.meanings import MEANINGS
from avahazard.records.table import Table

Place = tuple[int, str]  # index of the row, column
ODD = re.compile("[,\\s'’\u2212]")  # what a number of a file with commas does not hold, unquoted
ODD_ELSEWHERE = re.compile("[.,\\s'’\u2212]")
DECIMAL = {"point": "decimal points", "comma": "decimal commas"}
AMBIGUOUS = "a number: is this sign a decimal one or of thousands? Say --decimal point or comma"
MADE_A_DATE = "the text that was meant: the spreadsheet holds a date here"


def plain_cells(table: Table, given: Conventions, problems: list[RowProblem]) -> Table:
    """Return `table` with numbers such as 1234.5 and dates such as 1950-02-13, told in its words.

    The decimal sign is one in the whole file. Where the file does not show it and `given` does
    not say it, ambiguous numbers are added to `problems`, as are ambiguous dates.
    """
    rows = list(table.rows)
    words = list(table.words)
    words += _numbers(table, rows, given.decimal, problems)
    words += _dates(table, rows, given, problems)
    row_of = {line: k for k, line in enumerate(table.lines)} if table.dated else {}
    for line, column in sorted(table.dated):
        meaning = MEANINGS.get(column)
        if meaning and meaning.content in ("name", "text") and line in row_of:
            text = rows[row_of[line]].get(column, "")
            problems.append(RowProblem(table.file, line, column, text, MADE_A_DATE))
    return replace(table, rows=tuple(rows), words=tuple(words))


def _numbers(
    table: Table, rows: list[dict[str, str]], decimal: Decimal | None, problems: list[RowProblem]
) -> list[str]:
    columns = [name for name in table.header if _holds_numbers(name, rows)]
    odd = ODD if table.separator == "," else ODD_ELSEWHERE
    if not any(odd.search("".join(_values(c, rows))) for c in columns):
        return []
    places = [
        (k, c)
        for c in columns
        for k, cells in enumerate(rows)
        if c in cells and (table.written is None or (table.lines[k], c) in table.written)
    ]
    texts = [rows[k][c] for k, c in places]
    chosen = decimal or _decided(table, places, texts, weigh(texts), problems)
    if chosen is None or not places:
        return []
    grouped = False
    for (k, column), text in zip(places, texts, strict=True):
        found = canonical(text, chosen)
        if found is not None and found != text:
            grouped = grouped or len(found) < len(text)
            rows[k] = {**rows[k], column: found}
    words = [DECIMAL[chosen]] if table.written is None else [f"texts with {DECIMAL[chosen]}"]
    return [*words, *(["thousands in groups"] if grouped else [])]


def _decided(
    table: Table,
    places: Sequence[Place],
    texts: Sequence[str],
    found: Evidence,
    problems: list[RowProblem],
) -> Decimal | None:
    """The decimal sign that the numbers show, None after adding to `problems`."""
    if found.point and found.comma:
        rarer, sign = (
            (found.comma, "point")
            if len(found.comma) <= len(found.point)
            else (found.point, "comma")
        )
        first = table.lines[places[(found.point if sign == "point" else found.comma)[0]][0]]
        accepted = f"a decimal {sign}, as in line {first}: one sign in a file"
        _refuse(table, places, texts, rarer, accepted, problems)
        return None
    if found.point or found.comma:
        return "point" if found.point else "comma"
    # Between commas a point is the decimal one: so programs write numbers.
    doubtful = found.ambiguous
    if table.separator == ",":
        doubtful = [k for k in doubtful if "," in texts[k]]
    _refuse(table, places, texts, doubtful, AMBIGUOUS, problems)
    return None if doubtful else "point"


def _refuse(
    table: Table,
    places: Sequence[Place],
    texts: Sequence[str],
    which: Sequence[int],
    accepted: str,
    problems: list[RowProblem],
) -> None:
    for k in which:
        row, column = places[k]
        problems.append(RowProblem(table.file, table.lines[row], column, texts[k], accepted))


def _dates(
    table: Table, rows: list[dict[str, str]], given: Conventions, problems: list[RowProblem]
) -> list[str]:
    if "date" not in table.header:
        return []
    where = [k for k, cells in enumerate(rows) if "date" in cells]
    texts = [rows[k]["date"] for k in where]
    dates, faults, words = read_dates(texts, given.dates, table.first_day)
    for place, accepted in faults:
        line = table.lines[where[place]]
        problems.append(RowProblem(table.file, line, "date", texts[place], accepted))
    for k, text, date in zip(where, texts, dates, strict=True):
        if text != date:
            rows[k] = {**rows[k], "date": date}
    return [words] if words else []


def _holds_numbers(column: str, rows: Sequence[dict[str, str]]) -> bool:
    """A known column of numbers, or one of one's own in which most values are numbers."""
    meaning = MEANINGS.get(column)
    if meaning:
        return meaning.content in ("number", "flag")
    values = _values(column, rows)
    return 2 * sum(map(is_number, values)) > len(values)


def _values(column: str, rows: Sequence[dict[str, str]]) -> list[str]:
    return [cells[column] for cells in rows if column in cells]
