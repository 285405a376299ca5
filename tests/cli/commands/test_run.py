"""`avahazard run` as people and programs see it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.conftest import command_line
from tests.docs.test_results import check

pytestmark = pytest.mark.usefixtures("drawn_little")

PROJECT = """
files = ["world"]
skip = ["compare", "diagnose", "zones", "report"]
[model]
law = "constant"
chains = 2
draws = 100
"""


def test_people_and_programs(snow_world: Path, tmp_path: Path) -> None:
    shutil.copytree(snow_world / "world", tmp_path / "world")
    file = tmp_path / "avahazard.toml"
    file.write_text(PROJECT)
    run = command_line(tmp_path / "own.db")
    done = run("run", str(file))
    assert done.exit_code == 0, done.stderr
    words = " ".join(done.stdout.split())
    for step in ("import done", "calibrate base done", "hazard done", "export done bounds.csv"):
        assert step in words
    assert all(len(line) <= 80 for line in done.stdout.splitlines() if str(tmp_path) not in line)
    document = json.loads(run("--json", "run", str(file)).stdout)
    check("run", document)
    assert {step["state"] for step in document["steps"]} == {"up to date"}


def test_the_next_step_is_in_the_database_of_the_project(snow_world: Path, tmp_path: Path) -> None:
    shutil.copytree(snow_world / "world", tmp_path / "world")
    file = tmp_path / "avahazard.toml"
    file.write_text(f'database = "valley.db"\n{PROJECT}')
    done = command_line(tmp_path / "own.db")("run", str(file))
    assert done.exit_code == 0, done.stderr
    assert f"  avahazard --db {tmp_path / 'valley.db'} " in done.stdout


def test_a_file_at_fault(tmp_path: Path) -> None:
    file = tmp_path / "avahazard.toml"
    file.write_text("files = 3")
    done = command_line(tmp_path / "own.db")("run", str(file))
    assert done.exit_code == 1
    assert "files: Input should be a valid list (given: 3)." in " ".join(done.stderr.split())
    assert not (tmp_path / "own.db").exists()
