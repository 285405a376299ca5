"""The longest Tyrol profile, and the frictions to run on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile

FILE = Path(__file__).parents[3] / "shared" / "data" / "tyrol-profiles" / "profiles.csv"
MU = np.linspace(0.2, 0.7, 1000)
"""Frictions of the paper's range, `[1000]`; every block moves off."""


def longest(method: str) -> SmoothProfile:
    """Regularise the longest profile."""
    if not FILE.exists():
        raise SystemExit(f"The benchmarks need the Tyrol profiles at {FILE}.")
    table = pd.read_csv(FILE)
    name = table.groupby("path_id").x_m.max().idxmax()
    rows = table[table.path_id == name]
    return smooth_profile(rows.x_m.to_numpy(float), rows.y_m.to_numpy(float), method=method)
