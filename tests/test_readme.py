"""The commands in the README run as they are written, in the order of the page."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TABLES = (ROOT / "docs" / "paper_tables.md").read_text(encoding="utf-8")


def lines_of_blocks() -> list[str]:
    """Every command of the blocks of shell, without comments."""
    blocks = re.findall(r"^```(?:sh|console)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    lines = (
        line.removeprefix("$ ").split("  #")[0].strip() for b in blocks for line in b.split("\n")
    )
    return [line for line in lines if line and not line.startswith("#")]


def test_every_command_runs(tmp_path: Path) -> None:
    commands = lines_of_blocks()
    assert len(commands) >= 8
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in commands:
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
