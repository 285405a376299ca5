"""The commands in the README run as they are written, in the order of the page."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from avahazard.cli.main import app

pytestmark = pytest.mark.usefixtures("drawn_little")

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TABLES = (ROOT / "docs" / "paper_tables.md").read_text(encoding="utf-8")

# The same commands on less: enough to see that they work; `make test-slow` runs the real ones.
SMALLER = {
    "--events 90 --paths 5": "--events 36 --paths 3",
    "avahazard calibrate first": "avahazard calibrate first --chains 2 --draws 60",
}


def lines_of_blocks() -> list[str]:
    """Every command of the blocks of shell, without comments."""
    blocks = re.findall(r"^```(?:sh|console)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    lines = (
        line.removeprefix("$ ").split("  #")[0].strip() for b in blocks for line in b.split("\n")
    )
    return [line for line in lines if line and not line.startswith("#")]


def smaller(command: str) -> str:
    """The same command on less."""
    for old, new in SMALLER.items():
        command = command.replace(old, new)
    return command


def test_every_command_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("AVAHAZARD_DB", raising=False)
    commands = lines_of_blocks()
    assert len(commands) >= 8
    assert [part for part in SMALLER if not any(part in command for command in commands)] == []
    for command in commands:
        words = shlex.split(smaller(command).split(" > ")[0])
        assert words[0] == "avahazard"
        done = CliRunner().invoke(app, words[1:], prog_name="avahazard")
        assert done.exit_code == 0, f"{command}\n{done.output}\n{done.exception!r}"
        if " > " in command:
            assert json.loads(done.stdout)


@pytest.mark.slow
def test_every_command_runs_in_a_shell(tmp_path: Path) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in lines_of_blocks():
        done = subprocess.run(
            ["sh", "-c", command],
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"


def test_the_papers_tables_are_those_of_the_docs() -> None:
    rows = [line for line in TABLES.splitlines() if line.startswith("|")]
    assert len(rows) == 2 + 7 + 2 + 3
    assert [row for row in rows if row not in README] == []


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\]\((?!http)([^)#]+)\)", README))))
def test_links_lead_somewhere(name: str) -> None:
    assert (ROOT / name).exists()
