"""Bounds as a table for a spreadsheet."""

from __future__ import annotations

import csv
from pathlib import Path

from avahazard.report.hazard_csv import is_own_csv, write_hazard
from tests.gis.results import bounds_row


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
