"""`avahazard demo`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tests.cli.commands.conftest import PROGRAM
from tests.telling import untold


@pytest.mark.slow
def test_the_installed_command(tmp_path: Path) -> None:
    done = subprocess.run(
        [PROGRAM, "--json", "demo"], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    document = json.loads(done.stdout)
    assert document.keys() >= {"database", "files", "model", "hazard"}
    assert len(document["hazard"]) == 7
    for file in document["files"]:
        assert (tmp_path / file).is_file()
    assert {file.name for file in tmp_path.iterdir()} == {"avahazard-demo"}


def test_people_see_the_twin_its_files_and_how_to_go_on(tmp_path: Path) -> None:
    folder = tmp_path / "other"
    done = subprocess.run(
        [PROGRAM, "demo", "--folder", folder], check=True, capture_output=True, text=True
    )
    assert untold(done.stdout, "twin", "Ancey (2005)") == []
    assert str(folder / "twin.db") in done.stdout
    following = [line.split() for line in done.stdout.splitlines() if " --db " in line]
    assert len(following) >= 2
    subprocess.run([PROGRAM, *following[0][1:]], check=True, capture_output=True)
    # Where the command is not on the PATH, it is named as it was called.
    assert following[0][0] in ("avahazard", str(PROGRAM))


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "avahazard-demo").write_text("a file")
    done = subprocess.run(
        [PROGRAM, "demo"], cwd=tmp_path, check=False, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert untold(done.stderr, "avahazard-demo", "--folder") == []
    assert "Traceback" not in done.stderr
