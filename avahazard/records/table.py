"""A table of text cells, each row with its line number."""

from __future__ import annotations

import datetime as dt
from array import array
from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice, repeat
from operator import itemgetter
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.records.conventions import FIRST_DAY, UNKNOWN, Conventions, is_number
from avahazard.records.errors import Problems, RowProblem

Line = tuple[int, Sequence[str]]  # line number from 1, cells without the blanks around them
Cells = tuple[int, dict[str, str]]  # line number, the texts by column
Texts = NDArray[Any]
"""Texts of one column, of the type `TEXT`."""
TEXT = np.dtypes.StringDType()
"""Up to 15 bytes of text take 16 in an array of this type, a fourth of what they take alone."""
AT_ONCE = 10_000
"""Rows that are taken apart, or put together, at a time."""


class SheetLayout(NamedTuple):
    """Where a table stands on its sheet: rows of the header and of units, and merged cells.

    With `merged` a merged cell holds its value in each of its rows and columns; with `guess` the
    header is the row that looks like it.
    """

    header: int | None = None
    units: int | None = None
    merged: bool = False
    guess: bool = False


PLAIN = SheetLayout()


def texts(values: Sequence[str]) -> Texts:
    """A column of these values."""
    return np.array(values, dtype=TEXT)


LOOKED_AT = 15
"""Rows among which the header is looked for."""


def header_row(rows: Sequence[Line]) -> int:
    """Which of the first rows looks like the header: words, nearly as full as the fullest."""
    filled = [sum(map(bool, cells)) for _, cells in rows]
    for k, (_, cells) in enumerate(rows):
        words = sum(bool(cell) and not is_number(cell) for cell in cells)
        if words > 1 and 2 * words > filled[k] and filled[k] >= 0.6 * max(filled):
            return k
    return 0


LONGEST_NAME = 200
OfRange = Literal["geometric", "mean", "low", "high"]
"""Which number stands for a range such as `10-20`."""


class Column(NamedTuple):
    """The texts `[n_rows]` of a column, and what is known of it beside them.

    `spelt` is its name in the file, `unit` that of its numbers where it is not its own. `dated`
    are the lines in which a spreadsheet has a date, `written` those in which it has a text that is
    a number. A mapping gives the words of `classes` a number or word each, and says what a `range`
    is.
    """

    texts: Texts
    spelt: str
    unit: str = ""
    dated: Collection[int] = ()
    written: Collection[int] = ()
    classes: Mapping[str, float | str] | None = None
    range: OfRange | None = None


@dataclass(frozen=True, slots=True)
class FileTable:
    """Cells without the blanks around them: of each column those of `lines`.

    `name` hints at the form, `words` say how the file was read, `separator` is that of a text
    file, empty for a sheet with its `title` and `first_day`. `first` is the line of the header,
    `given` what the `mapping` says of the cells, by which its columns have their names.
    """

    file: str
    lines: array[int] = field(default_factory=lambda: array("q"))
    columns: Mapping[str, Column] = field(default_factory=dict)
    name: str = ""
    words: tuple[str, ...] = ()
    separator: str = ","
    title: str = ""
    first: int = 1
    first_day: dt.date = FIRST_DAY
    given: Conventions = UNKNOWN
    mapping: str = ""

    @property
    def header(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(self.columns)

    def numbered(self, columns: Sequence[str] | None = None) -> Iterator[Cells]:
        """Yield every row with its line number, or `columns` of it; empty cells are left out."""
        for begin in range(0, len(self.lines), AT_ONCE):
            yield from self.at(range(begin, min(begin + AT_ONCE, len(self.lines))), columns)

    def at(self, rows: Sequence[int], columns: Sequence[str] | None = None) -> Iterator[Cells]:
        """Yield some rows, in their order, by their numbers from 0, as `numbered` does."""
        names = self.header if columns is None else columns
        numbers = np.asarray(rows, dtype=np.intp)
        cells = [self.columns[name].texts[numbers].tolist() for name in names]
        full = not any("" in column for column in cells)
        taken = zip(*cells, strict=True) if cells else repeat((), len(rows))
        for k, row in zip(rows, taken, strict=True):
            named = zip(names, row, strict=True)
            yield self.lines[k], dict(named) if full else {name: t for name, t in named if t}

    def values(self, column: str) -> Iterator[tuple[int, str]]:
        """Give the numbers from 0 of the rows that have a text in the column, with the text."""
        return filter(itemgetter(1), enumerate(chain.from_iterable(self.blocks(column))))

    def counts(self, column: str) -> Counter[str]:
        """How often each text occurs in the column: few distinct ones, in many rows."""
        found = Counter(chain.from_iterable(self.blocks(column)))
        del found[""]
        return found

    def blocks(self, column: str) -> Iterator[list[str]]:
        """Yield the texts of a column, empty ones too, many rows at a time."""
        if column in self.columns:
            for begin in range(0, len(self.lines), AT_ONCE):
                yield self.columns[column].texts[begin : begin + AT_ONCE].tolist()


def table_of(
    file: str, header: Sequence[str], rows: Iterable[tuple[int, Mapping[str, str]]]
) -> FileTable:
    """A table of rows, each with its line number; cells may be left out."""
    numbered = list(rows)
    columns = {
        name: Column(texts([row.get(name, "") for _, row in numbered]), name) for name in header
    }
    return FileTable(file, array("q", [line for line, _ in numbered]), columns)


def filled(
    empty: FileTable,
    lines: Iterable[Line],
    problems: Problems,
    layout: SheetLayout = PLAIN,
    dated: Mapping[int, Collection[int]] = {},
    written: Mapping[int, Collection[int]] = {},
) -> FileTable | None:
    """The table with the cells of `lines`, blank ones left out, of which the first has the names.

    `dated` and `written` are lines by the number of their column, from 0. None where there is no
    line, and after adding to `problems` what is wrong with the names.
    """
    rows = (line for line in lines if line[0] >= (layout.header or 0))
    begin = list(islice(rows, LOOKED_AT))
    if not begin:
        return None
    likely = 0 if layout.header else header_row(begin)
    if layout.guess:
        begin, likely = begin[likely:], 0
    first, header = begin[0]
    named = [k for k, name in enumerate(header) if name]
    fewest = named[-1] + 1 if named else 0
    units: Sequence[str] = ()
    numbers = array("q")
    used = set(named)  # columns with a name, and those that hold something without one
    uneven: list[tuple[int, int]] = []

    def even() -> Iterator[Sequence[str]]:
        nonlocal units
        for line, cells in chain(begin[1:], rows):
            n = len(cells)
            if line == layout.units:
                units = cells
                continue
            if len(used) < len(header):
                used.update(k for k, cell in enumerate(cells[: len(header)]) if cell)
            # Spreadsheets leave columns that hold nothing, not even a name.
            while n > len(header) and not cells[n - 1]:
                n -= 1
            if fewest <= n <= len(header):
                numbers.append(line)
                yield cells
            else:
                uneven.append((line, bisect_left(named, n) + max(n - len(header), 0)))

    taken, blocks = even(), list[list[Texts]]()
    while block := list(islice(taken, AT_ONCE)):
        by_column = list(zip(*block, strict=False))
        blocks.append([texts(by_column[k]) for k in named])
    names = [header[k] for k in sorted(used)]
    faults = _faults_of_names(names, first, begin[likely][0])
    problems += [RowProblem(empty.file, first, *fault) for fault in faults]
    if faults:
        return None
    accepted = f"{len(names)} values, as many as the header has columns"
    if empty.separator == ",":
        accepted += " (a number with a decimal comma stands in quotes)"
    problems += [RowProblem(empty.file, line, "", f"{n} values", accepted) for line, n in uneven]
    unit = dict(enumerate(units))
    columns: dict[str, Column] = {}
    for k, *parts in zip(named, *blocks, strict=True):
        name, cells = header[k], np.concatenate([texts(()), *parts])
        known = dated.get(k, ()), written.get(k, ())
        columns[name] = Column(cells, name, unit.get(k, ""), *known)
    return replace(empty, lines=numbers, columns=columns, first=first)


def _faults_of_names(names: Sequence[str], first: int, likely: int) -> list[tuple[str, str, str]]:
    """Column, value and remedy of names that cannot be used; row `likely` is like a header."""
    if likely != first and (len(names) < 2 or not all(names)):
        accepted = (
            f"the header: it seems to be in row {likely}, and row {first} a title; take the "
            f"rows above it away, or write header = {likely} in columns.toml (import FILE "
            "--guess-columns writes one)"
        )
        return [("", names[0], accepted)]
    found = []
    for i, name in enumerate(names):
        if not name:
            found.append(("", "", f"a name for column {i + 1}"))
        elif len(name) > LONGEST_NAME:
            short = name[:40] + "…"
            found.append((short, short, f"a column name of at most {LONGEST_NAME} characters"))
        elif name in names[:i]:
            found.append((name, name, "each column name once"))
    return found
