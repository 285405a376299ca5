"""A table as it stands in a file, before anything is known of its columns."""

from __future__ import annotations

import datetime as dt
from array import array
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.records.errors import RowProblem
from avahazard.records.files.dates import FIRST_DAY

Line = tuple[int, Sequence[str]]  # line number from 1, cells without the blanks around them
Texts = NDArray[Any]
"""Texts of one column, of the type `TEXT`."""
TEXT = np.dtypes.StringDType()
"""Up to 15 bytes of text take 16 in an array of this type, a fourth of what they take alone."""
AT_ONCE = 10_000
"""Rows that are taken apart, or put together, at a time."""


class Cells(NamedTuple):
    """The lines of a table, blank ones left out: names, then `columns` of `lines` `[n_rows]`.

    `columns` are those with a name, in its order. `nameless` are columns (from 0) that hold
    something under an empty name. `uneven` lines have another number of values, `(line, values)`.
    """

    first: int
    names: tuple[str, ...]
    lines: array[int]
    columns: tuple[Texts, ...]
    nameless: frozenset[int]
    uneven: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Sheet:
    """The cells of a text file, or of one sheet of a workbook.

    `name` hints at the form; `words` say how it was read; `separator` is empty in a workbook.
    Of a workbook: `dated` are the cells `(line, column from 0)` that it holds as dates, `written`
    the numbers that it holds as texts (None: all, as in a text file); its days count from
    `first_day`.
    """

    file: str
    name: str
    cells: Cells
    words: tuple[str, ...]
    separator: str = ""
    dated: frozenset[tuple[int, int]] = frozenset()
    written: frozenset[tuple[int, int]] | None = None
    first_day: dt.date = FIRST_DAY


def no_header(file: str) -> RowProblem:
    """What is wrong with a file without a line."""
    return RowProblem(file, 1, "", "", "a header row with the names of the columns")


def texts(values: Sequence[str]) -> Texts:
    """A column of these values."""
    return np.array(values, dtype=TEXT)


def packed(lines: Iterable[Line]) -> Cells | None:
    """The cells of `lines`, of which the first has the names; None where there is no line."""
    rows = iter(lines)
    first, header = next(rows, (0, ()))
    if not first:
        return None
    named = [k for k, name in enumerate(header) if name]
    empty = [k for k, name in enumerate(header) if not name]
    fewest = named[-1] + 1 if named else 0
    numbers = array("q")
    held: list[Sequence[str]] = []
    blocks: list[list[Texts]] = []
    nameless: set[int] = set()
    uneven: list[tuple[int, int]] = []
    for line, cells in rows:
        n = len(cells)
        if empty:
            nameless.update(k for k in empty if k < n and cells[k])
        # Spreadsheets leave columns that hold nothing, not even a name.
        while n > len(header) and not cells[n - 1]:
            n -= 1
        if not fewest <= n <= len(header):
            uneven.append((line, bisect_left(named, n) + max(n - len(header), 0)))
            continue
        numbers.append(line)
        held.append(cells)
        if len(held) == AT_ONCE:
            blocks.append(_columns(held, named))
            held = []
    blocks.append(_columns(held, named))
    columns = tuple(np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return Cells(first, tuple(header), numbers, columns, frozenset(nameless), tuple(uneven))


def _columns(rows: Sequence[Sequence[str]], named: Sequence[int]) -> list[Texts]:
    """The named columns of rows that have at least these."""
    if not rows:
        return [texts(()) for _ in named]
    columns = list(zip(*rows, strict=False))
    return [texts(columns[k]) for k in named]
