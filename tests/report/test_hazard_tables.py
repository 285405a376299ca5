"""Bounds as a table for a spreadsheet."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from openpyxl import Workbook, load_workbook

from avahazard.report.hazard_tables import (
    hazard_sheet,
    is_own_csv,
    is_own_workbook,
    write_hazard,
    write_workbook,
    zones_sheet,
)
from tests.gis.results import bounds_row, zones


def written(file: Path, *paths: str, period: float | None = 100.0) -> list[dict[str, str]]:
    """Write bounds of these paths, and read them back."""
    write_hazard(file, [bounds_row(path, period) for path in paths])
    with file.open(newline="", encoding="utf-8") as handle:
        return list(csv.DictReader(handle))


def test_every_length_has_a_column_and_is_empty_beyond_the_profile(tmp_path: Path) -> None:
    (row,) = written(tmp_path / "bounds.csv", "P")
    assert (row["path_id"], row["return_period_years"], row["volume_m3"]) == (
        "P",
        "100.0",
        "20000.0",
    )
    assert (row["runout_x_q05_m"], row["runout_x_q95_m"]) == ("700.0", "")
    assert (row["design_runout_x_q95_m"], row["design_interval"]) == ("930.5", "uncertainty")
    assert row["design_runout_elevation_q50_m"] == "1536.8"
    assert (row["farthest_record_x_m"], row["records_beyond"]) == ("900.0", "1")
    assert list(row).index("design_runout_x_q05_m") < list(row).index("runout_x_q05_m")
    assert row["design_crs"].startswith("EPSG")
    assert {"natural_runout_x_q50_m", "parameters_runout_elevation_mean_m"} <= row.keys()
    (row,) = written(tmp_path / "bounds.csv", "P", period=None)
    assert row["return_period_years"] == ""
    assert "design_interval" not in row


def test_what_a_spreadsheet_would_run_is_made_harmless(tmp_path: Path) -> None:
    names = ["=1+1", "+1", "-1", "@a", "\tx", "\rx", 'a=1, "b"']
    rows = written(tmp_path / "bounds.csv", *names)
    assert [row["path_id"] for row in rows] == [*(f"'{name}" for name in names[:6]), names[6]]


def test_a_file_is_known_as_our_own(tmp_path: Path) -> None:
    file = tmp_path / "bounds.csv"
    written(file, "P")
    assert is_own_csv(file)
    file.write_text("path_id,x_m,y_m\n")
    assert not is_own_csv(file)


def test_numbers_and_texts_are_what_they_are(tmp_path: Path) -> None:
    file = tmp_path / "bounds.xlsx"
    rows = [bounds_row("=1+1", 100.0), bounds_row("P\x1b[31m", None)]
    sheets = {"hazard": hazard_sheet(rows), "zones": zones_sheet([zones("P")])}
    write_workbook(file, sheets)
    sheet, second = load_workbook(file).worksheets
    assert [cell.value for cell in second["A"]][:2] == ["path_id", "P"]
    header, *written = sheet.iter_rows()
    columns, flat = sheets["hazard"]
    assert [cell.value for cell in header] == columns
    by_name = dict(zip(columns, written[0], strict=True))
    assert (by_name["path_id"].value, by_name["path_id"].data_type) == ("=1+1", "s")
    assert by_name["runout_x_q05_m"].value == pytest.approx(flat[0]["runout_x_q05_m"])
    assert by_name["runout_x_q95_m"].value is None
    assert written[1][0].value == "P\ufffd[31m"


def test_a_workbook_is_known_as_our_own(tmp_path: Path) -> None:
    file = tmp_path / "bounds.xlsx"
    write_workbook(file, {"hazard": hazard_sheet([bounds_row("P", 100.0)])})
    assert is_own_workbook(file)
    Workbook().save(file)
    assert not is_own_workbook(file)
    file.write_text("no workbook")
    assert not is_own_workbook(file)
