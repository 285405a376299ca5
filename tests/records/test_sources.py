"""Files that a call names."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.records.sources import find_files


def test_a_folder_stands_for_its_csv_files_each_once(tmp_path: Path) -> None:
    for name in ("b.csv", "a.CSV", "notes.txt"):
        (tmp_path / name).touch()
    assert find_files([tmp_path / "b.csv", tmp_path]) == [tmp_path / "b.csv", tmp_path / "a.CSV"]


def test_missing_source_and_empty_folder_are_said(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no file or folder"):
        find_files([tmp_path / "none.csv"])
    with pytest.raises(AvahazardError, match="holds no table"):
        find_files([tmp_path])


def test_a_folder_may_hold_workbooks_but_not_two_files_of_one_name(tmp_path: Path) -> None:
    for name in ("events.xlsx", "paths.csv", "~$events.xlsx", ".hidden.csv"):
        (tmp_path / name).touch()
    assert [f.name for f in find_files([tmp_path])] == ["events.xlsx", "paths.csv"]
    (tmp_path / "Events.csv").touch()
    with pytest.raises(AvahazardError, match=r"Events\.csv and events\.xlsx") as caught:
        find_files([tmp_path])
    assert "Name the file" in caught.value.hint


def test_old_spreadsheets_are_not_passed_over(tmp_path: Path) -> None:
    for name in ("events.ods", "paths.csv"):
        (tmp_path / name).touch()
    with pytest.raises(AvahazardError, match=r"events\.ods") as caught:
        find_files([tmp_path])
    assert ".xlsx" in caught.value.hint
