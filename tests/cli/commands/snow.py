"""The command line on a database of one's own."""

from __future__ import annotations

import json
from typing import Any

from typer.testing import Result

from tests.conftest import command_line


def run(database: str, *words: str) -> Result:
    """Run a command."""
    return command_line(database)(*words)


def document(database: str, *words: str) -> Any:
    """Run a command and read its one document."""
    done = run(database, "--json", *words)
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def refused(database: str, *words: str, status: int = 1) -> str:
    """Run a command, which must end so; returns what it says."""
    done = run(database, *words)
    assert (done.exit_code, done.stdout) == (status, "")
    assert "Traceback" not in done.stderr
    assert isinstance(done.exception, SystemExit)
    return done.stderr
