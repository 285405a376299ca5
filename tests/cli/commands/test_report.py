"""`avahazard report`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from tests.cli.commands.conftest import PROGRAM


def test_the_installed_command(model_database: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [PROGRAM, "--db", model_database, "--json", "report", "base", "-o", "m.html"],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )
    document = json.loads(done.stdout)
    assert document["file"] == "m.html"
    assert (tmp_path / "m.html").stat().st_size == document["bytes"]


def test_a_wrong_ending_is_an_error_without_a_trace(model_database: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [PROGRAM, "--db", model_database, "report", "base", "-o", "m.pdf"],
        cwd=tmp_path,
        check=False,
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert "must end in .html" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_file_has_to_be_named(model_database: str) -> None:
    done = subprocess.run(
        [PROGRAM, "--db", model_database, "report", "base"], check=False, capture_output=True
    )
    assert done.returncode == 2
