"""A table of text cells, each row with its line number."""

from __future__ import annotations

import datetime as dt
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from operator import itemgetter
from pathlib import Path as FilePath

import numpy as np

from avahazard.arrays import Ints
from avahazard.records.conventions import FIRST_DAY, Conversion, Decimal, Order
from avahazard.records.errors import RowProblem
from avahazard.records.sheet import (
    AT_ONCE,
    PLAIN,
    Sheet,
    SheetCells,
    SheetLayout,
    Texts,
    decode,
    is_workbook,
    no_header,
    read_sheets,
    split,
    texts,
)

LONGEST_NAME = 200


@dataclass(frozen=True, slots=True)
class FileTable:
    """Cells without the blanks around them: of each column of the header those of `lines`.

    `name` hints at the form, `words` say how the file was read, `separator` is that of a text
    file; `spelt` gives a column as the file has it, where that differs. `first` is the line of the
    header; `title`, `dated`, `written` and `first_day` are those of the sheet, cells as
    `(line, column)`; `units` are those of a row under the header. The last four are what a mapping
    says of the cells.
    """

    file: str
    header: tuple[str, ...]
    lines: array[int]
    columns: Mapping[str, Texts]
    name: str = ""
    words: tuple[str, ...] = ()
    separator: str = ","
    title: str = ""
    first: int = 1
    dated: frozenset[tuple[int, str]] = frozenset()
    written: frozenset[tuple[int, str]] | None = None
    first_day: dt.date = FIRST_DAY
    spelt: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()
    decimal: Decimal | None = None
    dates: Order | None = None
    conversions: Mapping[str, Conversion] = field(default_factory=dict)

    def numbered(
        self, columns: Sequence[str] | None = None
    ) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield every row with its line number, or `columns` of it; empty cells are left out."""
        for begin in range(0, len(self.lines), AT_ONCE):
            rows = slice(begin, begin + AT_ONCE)
            yield from self._rows(self.lines[rows], rows, columns)

    def at(self, rows: Sequence[int]) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield some rows, in their order, by their numbers from 0."""
        yield from self._rows([self.lines[k] for k in rows], np.asarray(rows, dtype=np.intp), None)

    def values(self, column: str) -> Iterator[tuple[int, str]]:
        """Yield the numbers from 0 of the rows that have a text in the column, with the text."""
        for number, block in enumerate(self.blocks(column)):
            yield from filter(itemgetter(1), enumerate(block, number * AT_ONCE))

    def counts(self, column: str) -> Counter[str]:
        """How often each text occurs in the column: few distinct ones, in many rows."""
        found: Counter[str] = Counter()
        for block in self.blocks(column):
            found.update(block)
        del found[""]
        return found

    def blocks(self, column: str) -> Iterator[list[str]]:
        """Yield the texts of a column, empty ones too, many rows at a time."""
        if column in self.columns:
            for begin in range(0, len(self.lines), AT_ONCE):
                yield self.columns[column][begin : begin + AT_ONCE].tolist()

    def _rows(
        self, lines: Sequence[int], rows: slice | Ints, columns: Sequence[str] | None
    ) -> Iterator[tuple[int, dict[str, str]]]:
        names = self.header if columns is None else columns
        cells = [self.columns[name][rows].tolist() for name in names]
        full = not any("" in column for column in cells)
        taken = zip(*cells, strict=True) if cells else repeat((), len(lines))
        for line, row in zip(lines, taken, strict=True):
            named = zip(names, row, strict=True)
            yield line, dict(named) if full else {name: text for name, text in named if text}


def table_of(
    file: str, header: Sequence[str], rows: Iterable[tuple[int, Mapping[str, str]]]
) -> FileTable:
    """A table of rows, each with its line number; cells may be left out."""
    numbered = list(rows)
    columns = {name: texts([row.get(name, "") for _, row in numbered]) for name in header}
    return FileTable(file, tuple(header), array("q", [line for line, _ in numbered]), columns)


def read_tables(
    path: FilePath, problems: list[RowProblem], layout: SheetLayout = PLAIN
) -> list[FileTable]:
    """Read the table of a text file, or those of a workbook, cells as they were written.

    What is wrong is added to `problems`; a table without a usable header is left out.
    """
    file, raw = str(path), path.read_bytes()
    if is_workbook(raw):
        sheets = read_sheets(file, raw, problems, layout)
        if not sheets and not problems:
            problems.append(no_header(file))
    else:
        text = decode(file, raw, problems)
        del raw
        sheet = text and split(file, *text, problems, layout)
        sheets = [sheet] if sheet else []
    return [table for sheet in sheets if (table := _table(sheet, problems))]


def _table(sheet: Sheet, problems: list[RowProblem]) -> FileTable | None:
    cells = sheet.cells
    used = [k for k, name in enumerate(cells.names) if name or k in cells.nameless]
    header = _header(sheet.file, cells, used, problems)
    if not header:
        return None
    for line, n in cells.uneven:
        accepted = f"{len(header)} values, as many as the header has columns"
        if sheet.separator == ",":
            accepted += " (put a number with a decimal comma in quotes)"
        problems.append(RowProblem(sheet.file, line, "", f"{n} values", accepted))
    column = dict(zip(used, header, strict=True))
    return FileTable(
        sheet.file,
        header,
        cells.lines,
        dict(zip(header, cells.columns, strict=True)),
        sheet.name,
        sheet.words,
        sheet.separator,
        sheet.title,
        cells.first,
        _named(sheet.dated, column),
        None if sheet.written is None else _named(sheet.written, column),
        sheet.first_day,
        units={column[k]: text for k, text in enumerate(cells.units) if text and k in column},
    )


def _named(
    cells: frozenset[tuple[int, int]], column: Mapping[int, str]
) -> frozenset[tuple[int, str]]:
    return frozenset((line, column[k]) for line, k in cells if k in column)


def _header(
    file: str, table: SheetCells, used: Sequence[int], problems: list[RowProblem]
) -> tuple[str, ...]:
    """Check the names of the columns; an empty tuple when they cannot be used."""
    before, line = len(problems), table.first
    cells = [table.names[k] for k in used]
    if table.likely and (len(cells) < 2 or not all(cells)):
        accepted = (
            f"the header: it seems to be in row {table.likely}, and row {line} a title; take the "
            f"rows above it away, or write header = {table.likely} in columns.toml (import FILE "
            "--guess-columns writes one)"
        )
        problems.append(RowProblem(file, line, "", cells[0] if cells else "", accepted))
        return ()
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
