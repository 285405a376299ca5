"""The main job on the twin, from nothing; what it makes is in tests/cli/commands/test_demo.py."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.workflow.demo import run_demo


@pytest.mark.slow
def test_twice_into_one_folder(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    first, again = run_demo(folder), run_demo(folder)
    assert (folder / "notes.txt").read_text() == "mine"
    assert again.hazard == first.hazard
    assert again.loop.diagnosis == first.loop.diagnosis
    assert again.loop.hazard == first.loop.hazard


def test_a_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "demo").write_text("a file")
    with pytest.raises(AvahazardError, match="cannot be used") as caught:
        run_demo(tmp_path / "demo")
    assert "--folder" in caught.value.hint
