"""Compiled kernels survive the process that compiled them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PROGRAM = """
import numpy as np
from avahazard.physics import block, speed
from avahazard.physics.cells import build_cells
from avahazard.physics.resistance import no_resistance
from avahazard.physics.smooth_profile import legendre_profile
from avahazard.physics.terrain import build_terrain

x = np.linspace(0.0, 900.0, 50)
terrain = build_terrain(legendre_profile(x, 500.0 * np.exp(-x / 400.0)))
cells = build_cells(terrain, no_resistance(terrain))
block.run(cells, np.array([0]), np.array([0.5]))
speed.speeds_along(cells, 0, np.array([0.5]), np.array([100.0]))
for kernel in (block._run, speed._speeds):
    print(sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""


def counts(cache: Path) -> list[str]:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


def test_a_second_process_does_not_compile(tmp_path: Path) -> None:
    assert counts(tmp_path) == ["0 1", "0 1"]
    assert counts(tmp_path) == ["1 0", "1 0"]
