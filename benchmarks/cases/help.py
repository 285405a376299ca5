"""`avahazard --help` against importing typer, as whole processes."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.measuring import Result, processes


def measure() -> Result:
    """Times of a process."""
    command = [str(Path(sys.executable).parent / "avahazard"), "--help"]
    ours, theirs, ratio = processes(command, [sys.executable, "-c", "import typer"])
    return Result(
        ratio,
        ours,
        theirs,
        "s per process",
        1.5,
        True,
        'time of `avahazard --help` over that of `python -c "import typer"`',
        "whole processes; the smaller the better.",
    )
