"""`avahazard paths` on the demo data against importing SQLAlchemy, as whole processes."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib.resources import as_file, files
from pathlib import Path

from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from benchmarks.measuring import Result, alternate, seconds


def measure() -> Result:
    """Times of a process."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "demo.db")
        init_database(database)
        with as_file(files("avahazard.data")) as data:
            names = ("paths.csv", "profiles.csv", "events.csv")
            import_files(database, [data / name for name in names])
        program = str(Path(sys.executable).parent / "avahazard")
        command = [program, "--db", database, "paths"]
        rival = [sys.executable, "-c", "import sqlalchemy"]

        def process(words: list[str]) -> float:
            return seconds(lambda: subprocess.run(words, stdout=subprocess.DEVNULL, check=True))

        ours, theirs, inverse = alternate(lambda: process(command), lambda: process(rival), 15)
    return Result(
        1.0 / inverse,
        ours,
        theirs,
        "s per process",
        2.5,
        True,
        'time of `avahazard paths` over that of `python -c "import sqlalchemy"`',
        "whole processes, the demo's seven paths; the smaller the better.",
    )
