"""Files that are there whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from avahazard.whole_file import put_in_place, put_new_in_place


def test_what_is_put_in_place_is_synced_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part, file = tmp_path / "part", tmp_path / "whole"
    part.write_bytes(b"new")
    file.write_bytes(b"old")
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
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part, file = tmp_path / "part", tmp_path / "whole"
    part.write_bytes(b"new")
    file.write_bytes(b"old")

    def full(_opened: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        put_in_place(part, file)
    assert file.read_bytes() == b"old"


@pytest.mark.parametrize("links", [True, False])
def test_a_new_file_takes_no_name_that_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    def refused(_part: Path, _file: Path) -> None:
        raise OSError(1, "Operation not permitted")

    if not links:  # as on a disk that knows one name for a file
        monkeypatch.setattr(os, "link", refused)
    part, file = tmp_path / "part", tmp_path / "whole"
    part.write_bytes(b"new")
    file.write_bytes(b"old")
    with pytest.raises(FileExistsError):
        put_new_in_place(part, file)
    assert file.read_bytes() == b"old"
    file.unlink()
    put_new_in_place(part, file)
    assert file.read_bytes() == b"new"
    assert not part.exists()
