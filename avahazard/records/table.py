"""A CSV file as a table of text cells, each row with its line number."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath

from avahazard.records.errors import RowProblem

ENCODING = "a text file in UTF-8 (in a spreadsheet: save as 'CSV UTF-8, comma separated')"


@dataclass(frozen=True, slots=True)
class Table:
    """Cells without the blanks around them; empty cells are left out of a row."""

    file: str
    header: tuple[str, ...]
    lines: tuple[int, ...]
    rows: tuple[dict[str, str], ...]

    def numbered(self) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield every row with its line number."""
        return zip(self.lines, self.rows, strict=True)


def read_table(path: FilePath, problems: list[RowProblem]) -> Table | None:
    """Read `path`; add what is wrong with it to `problems`; None when it has no usable header."""
    file = str(path)
    text = _decode(file, path.read_bytes(), problems)
    if text is None:
        return None
    header: tuple[str, ...] = ()
    lines: list[int] = []
    rows: list[dict[str, str]] = []
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    line = 1
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                if not header:
                    header = _header(file, line, cells, problems)
                    if not header:
                        return None
                elif len(cells) != len(header):
                    accepted = f"{len(header)} values, as many as the header has columns"
                    problems.append(RowProblem(file, line, "", f"{len(cells)} values", accepted))
                else:
                    lines.append(line)
                    rows.append({k: v for k, v in zip(header, cells, strict=True) if v})
            line = reader.line_num + 1
    except csv.Error as error:
        problems.append(RowProblem(file, line, "", str(error), "rows of comma-separated values"))
        return None
    if not header:
        problems.append(RowProblem(file, 1, "", "", "a header row with the names of the columns"))
        return None
    return Table(file, header, tuple(lines), tuple(rows))


def _decode(file: str, raw: bytes, problems: list[RowProblem]) -> str | None:
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        problems.append(RowProblem(file, line, "", f"byte 0x{raw[error.start]:02x}", ENCODING))
        return None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        problems.append(RowProblem(file, line, "", "byte 0x00", ENCODING))
        return None
    return text


def _header(file: str, line: int, cells: list[str], problems: list[RowProblem]) -> tuple[str, ...]:
    """Check the names of the columns; an empty tuple when they cannot be used."""
    if len(cells) == 1 and (";" in cells[0] or "\t" in cells[0]):
        problems.append(RowProblem(file, line, "", cells[0], "columns separated by commas"))
        return ()
    before = len(problems)
    for i, name in enumerate(cells):
        if not name:
            accepted = f"a name for column {i + 1}"
            problems.append(RowProblem(file, line, "", "", accepted))
        elif len(name) > 200:
            accepted = "a column name of at most 200 characters"
            problems.append(RowProblem(file, line, name[:40] + "…", name[:40] + "…", accepted))
        elif name in cells[:i]:
            problems.append(RowProblem(file, line, name, name, "each column name once"))
    return () if len(problems) > before else tuple(cells)
