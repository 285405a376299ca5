"""The installed command on a database of one's own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

PROGRAM = Path(sys.executable).with_name("avahazard")


def run(database: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the installed command."""
    return subprocess.run(
        [PROGRAM, "--db", database, *words], check=False, capture_output=True, text=True
    )


def document(database: str, *words: str) -> Any:
    """Run the installed command and read its one document."""
    done = run(database, "--json", *words)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def refused(database: str, *words: str, status: int = 1) -> str:
    """Run the installed command, which must end so; returns what it says."""
    done = run(database, *words)
    assert (done.returncode, done.stdout) == (status, "")
    assert "Traceback" not in done.stderr
    return done.stderr
