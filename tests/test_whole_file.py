"""Files that are there whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from avahazard.whole_file import written_whole


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Give a file that says old."""
    file = tmp_path / "whole.txt"
    file.write_bytes(b"old")
    return file


def renew(file: Path) -> None:
    with written_whole(file) as part:
        assert part.suffix == file.suffix
        part.write_bytes(b"new")


def test_what_is_put_in_place_is_synced_before_it_has_its_name(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    sync = os.fsync

    def watched(opened: int) -> None:
        seen.append(file.read_bytes())
        sync(opened)

    monkeypatch.setattr(os, "fsync", watched)
    renew(file)
    assert seen[0] == b"old"
    assert seen[1:] == [b"new"]  # the folder, which knows the name
    assert file.read_bytes() == b"new"
    assert list(file.parent.iterdir()) == [file]


def test_a_disk_that_refuses_leaves_the_file_as_it_was(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:

    def full(_opened: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        renew(file)
    assert file.read_bytes() == b"old"
    assert list(file.parent.iterdir()) == [file]
