"""`avahazard --help` against importing typer, as whole processes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from benchmarks.measuring import Result, alternate, seconds


def measure() -> Result:
    """Times of a process."""
    command = [str(Path(sys.executable).parent / "avahazard"), "--help"]
    rival = [sys.executable, "-c", "import typer"]

    def process(words: list[str]) -> float:
        return seconds(lambda: subprocess.run(words, stdout=subprocess.DEVNULL, check=True))

    ours, theirs, inverse = alternate(lambda: process(command), lambda: process(rival), 15)
    return Result(
        1.0 / inverse,
        ours,
        theirs,
        "s per process",
        1.5,
        True,
        'time of `avahazard --help` over that of `python -c "import typer"`',
        "whole processes; the smaller the better.",
    )
