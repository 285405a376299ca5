"""Profiles that the tests of physics run on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import solve_banded

from avahazard.physics import smooth_profile
from avahazard.physics.cells import Cells, Resistance, build_cells, no_resistance
from avahazard.physics.smooth_profile import (
    SmoothProfile,
    block_length,
    legendre_profile,
    point_error,
)
from avahazard.physics.terrain import Terrain, build_terrain

RELEASE_M = 100.0


def bowl(length: float = 2500.0, drop: float = 1000.0) -> SmoothProfile:
    """A smooth concave path that is steep at the top and runs out flat."""
    x = np.linspace(0.0, length, 126)
    return legendre_profile(x, 2000.0 - drop * 1.07 * (1.0 - np.exp(-x / (0.36 * length))))


def profile_of(function: Callable[[np.ndarray], np.ndarray], length: float) -> SmoothProfile:
    """The polynomial of degree 8 through a function of x on [0, length]."""
    x = np.linspace(0.0, length, 400)
    return legendre_profile(x, function(x), penalty=1e-12)


def spline_profile(
    x: np.ndarray, y: np.ndarray, sigma: float | None = None, block_m: float | None = None
) -> SmoothProfile:
    """The smoothing spline of points that all have the error `sigma` (m), estimated where None."""
    error = point_error(x, y, None if sigma is None else np.full(len(x), sigma))
    length = block_length(float(x[-1] - x[0])) if block_m is None else block_m
    return smooth_profile.spline_profile(x, y, error, length)


def ski_jump() -> SmoothProfile:
    """A slope that bends down sharply half-way, so that fast blocks fly, and then runs out."""
    x = np.linspace(0.0, 1500.0, 151)
    y = 1000.0 - 0.45 * x - 80.0 / (1.0 + np.exp(-(x - 500.0) / 25.0)) + (x / 105.0) ** 2
    return spline_profile(x, y, 0.05)


def drawn_profile(smooth: SmoothProfile, rng: np.random.Generator) -> SmoothProfile:
    """The path as it might be, given its points and their error."""
    ground = smooth.posterior
    assert ground is not None
    off = solve_banded((0, 3), ground.factor, rng.standard_normal(len(ground.mean)))
    f = replace(ground, mean=ground.mean + off).ground()
    return replace(smooth, knots=ground.knots[4:-4], curve=f)


def cells_of(terrain: Terrain, **changes: object) -> Cells:
    """Cells with some resistance, by the fields of `Resistance`; numbers hold everywhere."""
    fields = {name: getattr(no_resistance(terrain), name) for name in Resistance.__slots__}
    for name, value in changes.items():
        everywhere = name in ("factor", "offset", "constant", "drag") and np.isscalar(value)
        fields[name] = np.full(terrain.n_cells, value) if everywhere else value
    return build_cells(terrain, Resistance(**fields))


def terrain_of(profile: SmoothProfile, release: float = RELEASE_M, **options: float) -> Terrain:
    """Terrain with a node at the release."""
    return build_terrain(profile, np.array([release]), **options)


def read_profiles(file: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """x and y of each path of a `profiles.csv`."""
    table = pd.read_csv(file)
    return {
        str(name): (rows.x_m.to_numpy(float), rows.y_m.to_numpy(float))
        for name, rows in table.groupby("path_id")
    }
