"""The twin's 173 events with the table F(μ) of each path."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import EVEN, MU, MU_STEP, tabulate
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.physics.terrain import build_terrain

Floats = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "data"


class Twin(NamedTuple):
    """Arrays `[n_events]`, and `stop_y` `[n_paths, n_mu]`; `mu` is only to start from."""

    volume: Floats
    runout: Floats
    table: NDArray[np.int64]
    stop_y: Floats
    mu_min: float
    mu_step: float
    mu: Floats


def twin() -> Twin:
    """Read the twin; blocks start from their path's release, an event that left is at the end."""
    paths = pd.read_csv(DATA / "paths.csv").set_index("path_id")
    profiles = pd.read_csv(DATA / "profiles.csv")
    events = pd.read_csv(DATA / "events.csv")
    names = list(paths.index)
    stop_y = np.empty((len(names), len(MU[EVEN])))
    ends = np.empty(len(names))
    for k, name in enumerate(names):
        rows = profiles[profiles.path_id == name]
        smooth = smooth_profile(rows.x_m.to_numpy(float), rows.y_m.to_numpy(float))
        fine = np.linspace(smooth.x_min, smooth.x_max, 20_000)
        release = fine[np.argmax(smooth.height(fine) <= paths.release_elevation_m[name])]
        terrain = build_terrain(smooth, np.array([release]))
        table = tabulate(
            build_cells(terrain, no_resistance(terrain)), np.array([terrain.node(release)])
        )
        stop_y[k] = np.where(table.left[0], terrain.y[-1], table.y[0])[EVEN]
        ends[k] = terrain.y[-1]
    which = events.path_id.map({name: k for k, name in enumerate(names)}).to_numpy(np.int64)
    runout = events.runout_elevation_m.fillna(pd.Series(ends[which])).to_numpy(float)
    volume = events.volume_m3.to_numpy(float)
    near = [np.argmin(np.abs(stop_y[k] - y)) for k, y in zip(which, runout, strict=True)]
    return Twin(volume, runout, which, stop_y, float(MU[EVEN][0]), MU_STEP, MU[EVEN][near])
