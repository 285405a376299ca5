"""A table as it stands in a file, before anything is known of its columns."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass

from avahazard.records.files.dates import FIRST_DAY

Line = tuple[int, tuple[str, ...]]  # line number from 1, cells without the blanks around them


@dataclass(frozen=True, slots=True)
class Sheet:
    """The rows of a text file, or of one sheet of a workbook, blank ones left out.

    A table of it takes its rows away, so that they are not held twice.

    `name` hints at the form; `words` say how it was read; `separator` is empty in a workbook.
    Of a workbook: `dated` are the cells `(line, column from 0)` that it holds as dates, `written`
    the numbers that it holds as texts (None: all, as in a text file); its days count from
    `first_day`.
    """

    file: str
    name: str
    lines: list[Line]
    words: tuple[str, ...]
    separator: str = ""
    dated: frozenset[tuple[int, int]] = frozenset()
    written: frozenset[tuple[int, int]] | None = None
    first_day: dt.date = FIRST_DAY
