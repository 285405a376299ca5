"""`avahazard paths` on the demo data against importing SQLAlchemy, as whole processes."""

from __future__ import annotations

import sys
import tempfile
from importlib.resources import as_file, files
from pathlib import Path

from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from benchmarks.measuring import Result, processes


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
        ours, theirs, ratio = processes(command, [sys.executable, "-c", "import sqlalchemy"])
    return Result(
        ratio,
        ours,
        theirs,
        "s per process",
        2.5,
        True,
        'time of `avahazard paths` over that of `python -c "import sqlalchemy"`',
        "whole processes, the demo's seven paths; the smaller the better.",
    )
