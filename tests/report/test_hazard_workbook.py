"""Bounds as a workbook."""

from __future__ import annotations

from pathlib import Path

import pytest
from openpyxl import Workbook, load_workbook

from avahazard.report.hazard_csv import hazard_table
from avahazard.report.hazard_workbook import is_own_workbook, write_hazard_workbook
from tests.gis.results import bounds_row


def test_numbers_and_texts_are_what_they_are(tmp_path: Path) -> None:
    file = tmp_path / "bounds.xlsx"
    rows = [bounds_row("=1+1", 100.0), bounds_row("P\x1b[31m", None)]
    write_hazard_workbook(file, rows)
    (sheet,) = load_workbook(file).worksheets
    header, *written = sheet.iter_rows()
    columns, flat = hazard_table(rows)
    assert [cell.value for cell in header] == columns
    by_name = dict(zip(columns, written[0], strict=True))
    assert (by_name["path_id"].value, by_name["path_id"].data_type) == ("=1+1", "s")
    assert by_name["runout_x_q05_m"].value == pytest.approx(flat[0]["runout_x_q05_m"])
    assert by_name["runout_x_q95_m"].value is None
    assert written[1][0].value == "P\ufffd[31m"


def test_a_workbook_is_known_as_our_own(tmp_path: Path) -> None:
    file = tmp_path / "bounds.xlsx"
    write_hazard_workbook(file, [bounds_row("P", 100.0)])
    assert is_own_workbook(file)
    Workbook().save(file)
    assert not is_own_workbook(file)
    file.write_text("no workbook")
    assert not is_own_workbook(file)
