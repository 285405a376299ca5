"""A table of text cells, each row with its line number."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath

from avahazard.records.errors import RowProblem
from avahazard.records.files.dates import FIRST_DAY
from avahazard.records.files.encoding import decode
from avahazard.records.files.separators import split
from avahazard.records.files.sheet import Sheet
from avahazard.records.files.workbook import is_workbook, read_sheets

LONGEST_NAME = 200


@dataclass(frozen=True, slots=True)
class Table:
    """Cells without the blanks around them; empty cells are left out of a row.

    `name` hints at the form, `words` say how the file was read, `separator` is that of a text
    file; `spelt` gives a column as the file has it, where that differs. `dated`, `written` and
    `first_day` are those of the sheet, cells as `(line, column)`.
    """

    file: str
    header: tuple[str, ...]
    lines: tuple[int, ...]
    rows: tuple[dict[str, str], ...]
    name: str = ""
    words: tuple[str, ...] = ()
    separator: str = ","
    dated: frozenset[tuple[int, str]] = frozenset()
    written: frozenset[tuple[int, str]] | None = None
    first_day: dt.date = FIRST_DAY
    spelt: Mapping[str, str] = field(default_factory=dict)

    def numbered(self) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield every row with its line number."""
        return zip(self.lines, self.rows, strict=True)


def read_tables(path: FilePath, problems: list[RowProblem]) -> list[Table]:
    """Read the table of a text file, or those of a workbook, cells as they were written.

    What is wrong is added to `problems`; a table without a usable header is left out.
    """
    file, raw = str(path), path.read_bytes()
    if is_workbook(raw):
        sheets = read_sheets(file, raw, problems)
        if not sheets and not problems:
            problems.append(_no_header(file))
    else:
        text = decode(file, raw, problems)
        sheet = text and split(file, *text, problems)
        sheets = [sheet] if sheet else []
        del text
    del raw
    return [table for sheet in sheets if (table := _table(sheet, problems))]


def _table(sheet: Sheet, problems: list[RowProblem]) -> Table | None:
    if not sheet.lines:
        problems.append(_no_header(sheet.file))
        return None
    first, names = sheet.lines[0]
    # Spreadsheets leave columns that hold nothing, not even a name.
    used = [
        k
        for k in range(max(len(cells) for _, cells in sheet.lines))
        if any(k < len(cells) and cells[k] for _, cells in sheet.lines)
    ]
    blank = {k for k in range(len(names)) if k not in used}
    header = _header(sheet.file, first, [n for k, n in enumerate(names) if k in used], problems)
    if not header:
        return None
    lines: list[int] = []
    rows: list[dict[str, str]] = []
    sheet.lines.reverse()
    sheet.lines.pop()
    while sheet.lines:
        line, cells = sheet.lines.pop()
        here = [c for k, c in enumerate(cells) if k not in blank] if blank else list(cells)
        while len(here) > len(header) and not here[-1]:
            here.pop()
        if len(here) != len(header):
            accepted = f"{len(header)} values, as many as the header has columns"
            if sheet.separator == ",":
                accepted += " (a number with a decimal comma stands in quotes)"
            problems.append(RowProblem(sheet.file, line, "", f"{len(here)} values", accepted))
        else:
            lines.append(line)
            rows.append({k: v for k, v in zip(header, here, strict=True) if v})
    column = {k: name for name, k in zip(header, used, strict=False)}
    return Table(
        sheet.file,
        header,
        tuple(lines),
        tuple(rows),
        sheet.name,
        sheet.words,
        sheet.separator,
        _named(sheet.dated, column),
        None if sheet.written is None else _named(sheet.written, column),
        sheet.first_day,
    )


def _named(
    cells: frozenset[tuple[int, int]], column: Mapping[int, str]
) -> frozenset[tuple[int, str]]:
    return frozenset((line, column[k]) for line, k in cells if k in column)


def _no_header(file: str) -> RowProblem:
    return RowProblem(file, 1, "", "", "a header row with the names of the columns")


def _header(file: str, line: int, cells: list[str], problems: list[RowProblem]) -> tuple[str, ...]:
    """Check the names of the columns; an empty tuple when they cannot be used."""
    before = len(problems)
    for i, name in enumerate(cells):
        if not name:
            accepted = f"a name for column {i + 1}"
            problems.append(RowProblem(file, line, "", "", accepted))
        elif len(name) > LONGEST_NAME:
            accepted = f"a column name of at most {LONGEST_NAME} characters"
            problems.append(RowProblem(file, line, name[:40] + "…", name[:40] + "…", accepted))
        elif name in cells[:i]:
            problems.append(RowProblem(file, line, name, name, "each column name once"))
    return () if len(problems) > before else tuple(cells)
