"""The sheets of a workbook (.xlsx): numbers and dates as the spreadsheet holds them."""

from __future__ import annotations

import datetime as dt
import io
import warnings
import zipfile
from pathlib import PurePath
from typing import Any

from avahazard.records.errors import RowProblem
from avahazard.records.files.dates import FIRST_DAY
from avahazard.records.files.numbers import is_number
from avahazard.records.files.sheet import Line, Sheet, packed

ZIP, OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
ACCEPTED = "a workbook saved as .xlsx without a password, or a text file (CSV)"
FIRST_DAY_1904 = dt.date(1904, 1, 1)
MOST_BYTES = 1_000_000_000  # unpacked; a small file can hold endless zeros


def is_workbook(raw: bytes) -> bool:
    """Tell whether a spreadsheet program wrote the file, whatever its name."""
    return raw.startswith((ZIP, OLE))


def read_sheets(file: str, raw: bytes, problems: list[RowProblem]) -> list[Sheet]:
    """Return the sheets that hold anything; add to `problems` the cells that cannot be read."""
    try:
        if raw.startswith(OLE) or _unpacked(raw) > MOST_BYTES:
            raise zipfile.BadZipFile
        book = _load(raw, values=False)
        formulas = {
            (sheet.title, cell.coordinate)
            for sheet in book.worksheets
            for row in sheet.iter_rows()
            for cell in row
            if cell.data_type == "f"
        }
        if formulas:
            book = _load(raw, values=True)
    except Exception:
        problems.append(RowProblem(file, 0, "", PurePath(file).name, ACCEPTED))
        return []
    several = len(book.worksheets) > 1
    found = [_sheet(file, sheet, several, formulas, problems) for sheet in book.worksheets]
    return [sheet for sheet in found if sheet is not None]


def _load(raw: bytes, *, values: bool) -> Any:
    from openpyxl import load_workbook  # noqa: PLC0415 (slow to import)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what it leaves out: colours, lists of choices
        return load_workbook(io.BytesIO(raw), data_only=values)


def _unpacked(raw: bytes) -> int:
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        return sum(entry.file_size for entry in archive.infolist())


def _sheet(
    file: str,
    sheet: Any,
    several: bool,
    formulas: set[tuple[str, str]],
    problems: list[RowProblem],
) -> Sheet | None:
    from openpyxl.utils.datetime import CALENDAR_MAC_1904  # noqa: PLC0415 (slow to import)

    label = f"{file}, sheet {sheet.title}" if several else file
    lines: list[Line] = []
    dated: set[tuple[int, int]] = set()
    written: set[tuple[int, int]] = set()
    for row in sheet.iter_rows():
        texts = []
        for cell in row:
            text, fault = _text(cell.value, cell.data_type)
            if cell.value is None and (sheet.title, cell.coordinate) in formulas:
                fault = "the value of the formula: open the file in a spreadsheet and save it"
            if fault:
                problems.append(RowProblem(label, cell.row, cell.column_letter, text, fault))
            if cell.data_type == "d":
                dated.add((cell.row, cell.column - 1))
            elif cell.data_type != "n" and is_number(text):
                written.add((cell.row, cell.column - 1))
            texts.append(text)
        if any(texts):
            lines.append((row[0].row, tuple(texts)))
    cells = packed(lines)
    if cells is None:
        return None
    for merged in sheet.merged_cells.ranges:
        if merged.max_row > cells.first:
            accepted = "cells that are not merged: each row with values of its own"
            problems.append(RowProblem(label, merged.min_row, "", str(merged), accepted))
    name = sheet.title if several else PurePath(file).stem
    return Sheet(
        label,
        name,
        cells,
        ("workbook",),
        dated=frozenset(dated),
        written=frozenset(written),
        first_day=FIRST_DAY_1904 if sheet.parent.epoch == CALENDAR_MAC_1904 else FIRST_DAY,
    )


def _text(value: Any, kind: str) -> tuple[str, str]:
    """A cell as text, and what would be accepted if it cannot be."""
    if value is None:
        return "", ""
    if kind == "e":
        return str(value), "a value: the spreadsheet could not compute this cell"
    if isinstance(value, bool):
        return str(int(value)), ""
    if isinstance(value, float):
        return (str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)), ""
    if isinstance(value, dt.datetime):
        return value.date().isoformat(), ""
    return str(value).strip(), ""
