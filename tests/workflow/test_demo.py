"""The main job on the twin, from nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.upkeep import status
from avahazard.workflow.demo import run_demo
from tests.workflow.twin import TRUTH


def test_twice_into_one_folder(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "demo"
    folder.mkdir(parents=True)
    (folder / "notes.txt").write_text("mine")
    first = run_demo(folder)
    again = run_demo(folder)
    assert (folder / "notes.txt").read_text() == "mine"
    for file in first["files"]:
        assert Path(file).stat().st_size > 0
    assert again["hazard"] == first["hazard"]
    assert len(first["hazard"]) == 7
    assert all(None not in row["runout_x_m"].values() for row in first["hazard"])
    counts = status(first["database"]).counts
    assert (counts["events"], counts["models"]) == (173, 2)
    for model in (first["model"], first["gibbs"]):
        assert model["diagnostics"]["converged"]
        for name, value in TRUTH.items():
            found = model["parameters"][name]
            assert found["q05"] < value < found["q95"], (model["model"], name)


def test_a_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "demo").write_text("a file")
    with pytest.raises(AvahazardError, match="cannot be used") as caught:
        run_demo(tmp_path / "demo")
    assert "--folder" in caught.value.hint
