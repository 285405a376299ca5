"""The slope of `tests.engines.slope` with a table of runs, and a model calibrated on it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from avahazard.engines.com1dfa import PLACE
from tests.conftest import command_line
from tests.engines.slope import write_program, write_slope

TABLE = [f"--friction={mu:.3f}" for mu in np.linspace(0.2, 0.6, 9)]


def make_slope(folder: Path) -> None:
    """Write the slope into a folder, run the program in AvaFrame's place on it and calibrate."""
    write_slope(folder)
    program = write_program(folder)
    database = folder / "avahazard.db"
    run = command_line(database)
    os.environ[PLACE] = str(program)
    try:
        for words in (
            ["init"],
            ["import", str(folder / "line.gpkg"), "--dem", str(folder / "dem.tif")],
            ["import", str(folder / "events.csv")],
            ["simulate", "-V", "3000", "-V", "40000", *TABLE],
            ["calibrate", "flow", "--forward", "com1dfa", "--draws", "250"],
        ):
            found = run(*words)
            assert found.exit_code == 0, found.output
    finally:
        del os.environ[PLACE]
