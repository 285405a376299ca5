"""The rows of a text file, and what stands between its values."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import PurePath

from avahazard.records.errors import RowProblem
from avahazard.records.files.names import known_name
from avahazard.records.files.sheet import Line, Sheet, no_header, packed

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
LINE = re.compile(r"[^\r\n]*(?:\r\n?|\n)|[^\r\n]+")
HINT = re.compile(r"sep=(.)\r?\n", re.IGNORECASE)  # what Excel writes for itself


def split(file: str, text: str, encoding: str, problems: list[RowProblem]) -> Sheet | None:
    """Return the rows of `text`; None after adding to `problems`."""
    start = HINT.match(text)
    separator = start.group(1) if start else _separator(text)
    if separator not in SEPARATORS:
        names = ", ".join(SEPARATORS.values())
        problems.append(RowProblem(file, 1, "", separator, f"values separated by {names}"))
        return None
    before = len(problems)
    cells = packed(_filled(file, text, separator, start is not None, problems))
    if len(problems) > before:
        return None
    if cells is None:
        problems.append(no_header(file))
        return None
    words = (encoding, SEPARATORS[separator])
    return Sheet(file, PurePath(file).stem, cells, words, separator)


def _filled(
    file: str, text: str, separator: str, skip_first: bool, problems: list[RowProblem]
) -> Iterator[Line]:
    """The rows that hold anything, with the line where each begins, as far as they can be read."""
    reader = csv.reader(_lines(text), delimiter=separator, strict=True)
    line = 1
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells) and not (skip_first and line == 1):
                yield line, cells
            line = reader.line_num + 1
    except csv.Error as error:
        accepted = f"rows of values separated by {SEPARATORS[separator]}"
        problems.append(RowProblem(file, line, "", str(error), accepted))


def _separator(text: str) -> str:
    """The one by which the header has the most known columns; else the most columns."""

    def rank(separator: str) -> tuple[int, int]:
        header = next(_records(text, separator), [])
        return sum(known_name(name) is not None for name in header), len(header)

    return max(SEPARATORS, key=rank)


def _lines(text: str) -> Iterator[str]:
    """The lines with their ends, one by one: a second text would be four times as large."""
    return (found.group() for found in LINE.finditer(text))


def _records(text: str, separator: str) -> Iterator[list[str]]:
    try:
        for row in csv.reader(_lines(text), delimiter=separator):
            if any(cell.strip() for cell in row):
                yield row
    except csv.Error:
        return
