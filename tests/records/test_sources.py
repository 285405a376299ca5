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
    with pytest.raises(AvahazardError, match="holds no CSV file"):
        find_files([tmp_path])
