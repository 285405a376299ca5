"""Bounds of the runout as a workbook."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

from avahazard.report.hazard_csv import hazard_table
from avahazard.results.hazard import HazardRow

CREATOR = "avahazard"
NOT_IN_CELLS = re.compile(r"[\x00-\x08\x0b-\x1f]")  # a workbook with one of them does not open


def write_hazard_workbook(file: FilePath, rows: Sequence[HazardRow]) -> None:
    """Write the rows of `hazard` as .xlsx: lengths in m, an empty cell beyond the profile.

    Numbers are numbers, and texts are texts, also those that begin like a formula.
    """
    from openpyxl import Workbook  # noqa: PLC0415 (slow to import)

    columns, flat = hazard_table(rows)
    book = Workbook()
    book.properties.creator = CREATOR
    sheet = book.active
    sheet.title = "hazard"
    sheet.append(columns)
    for line, row in enumerate(flat, start=2):
        for column, name in enumerate(columns, start=1):
            value = _cell(row.get(name))
            if value is not None:
                cell = sheet.cell(line, column, value)
                if isinstance(value, str):
                    cell.data_type = "s"
    sheet.freeze_panes = "B2"
    book.save(file)


def is_own_workbook(file: FilePath) -> bool:
    """Whether `file` was made by `write_hazard_workbook`."""
    from openpyxl import load_workbook  # noqa: PLC0415 (slow to import)

    try:
        book = load_workbook(file, read_only=True)
    except Exception:
        return False
    own: bool = book.properties.creator == CREATOR and book.sheetnames == ["hazard"]
    book.close()
    return own


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 4)
    if isinstance(value, str):
        return NOT_IN_CELLS.sub("\N{REPLACEMENT CHARACTER}", value)
    return value
