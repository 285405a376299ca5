"""Files that are there whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from avahazard.whole_file import put_in_place


@pytest.fixture
def part_and_file(tmp_path: Path) -> tuple[Path, Path]:
    """Give what is to be put in place, which says new, and the file there, which says old."""
    part, file = tmp_path / "part", tmp_path / "whole"
    part.write_bytes(b"new")
    file.write_bytes(b"old")
    return part, file


def test_what_is_put_in_place_is_synced_before_it_has_its_name(
    part_and_file: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    part, file = part_and_file
    seen = []
    sync = os.fsync

    def watched(opened: int) -> None:
        seen.append(file.read_bytes())
        sync(opened)

    monkeypatch.setattr(os, "fsync", watched)
    put_in_place(part, file)
    assert seen[0] == b"old"
    assert seen[1:] == [b"new"]  # the folder, which knows the name
    assert file.read_bytes() == b"new"
    assert not part.exists()


def test_a_disk_that_refuses_leaves_the_file_as_it_was(
    part_and_file: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    part, file = part_and_file

    def full(_opened: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        put_in_place(part, file)
    assert file.read_bytes() == b"old"
