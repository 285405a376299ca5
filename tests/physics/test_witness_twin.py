"""Stops and speeds against scipy's integrator in time, on the twin's paths and with effects."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.physics.speed import speeds_along
from tests.conftest import ROOT
from tests.physics.comparing import compare
from tests.physics.paths import bowl, cells_of, read_profiles, ski_jump, terrain_of
from tests.physics.witness import pieces, witness

TWIN = sorted(read_profiles(ROOT / "data" / "profiles.csv"))
SHORT = ("scey",)
"""Paths whose runs by the witness take least."""


@pytest.mark.parametrize(
    "path", [p if p in SHORT else pytest.param(p, marks=pytest.mark.slow) for p in TWIN]
)
def test_twin(path: str) -> None:
    x, y = read_profiles(ROOT / "data" / "profiles.csv")[path]
    compare(smooth_profile(x, y), x[0], 20 if path in SHORT else 50)


@pytest.mark.parametrize(
    "effects", [{"drag": 0.004}, {"constant": 0.5}, {"curvature": 0.0}], ids=lambda e: next(iter(e))
)
@pytest.mark.parametrize("profile", [bowl(), ski_jump()], ids=["bowl", "jump"])
def test_effects(profile: SmoothProfile, effects: dict[str, float]) -> None:
    terrain = terrain_of(profile)
    cells, start = cells_of(terrain, **effects), terrain.node(100.0)
    path, mu = pieces(profile), np.linspace(0.2, 0.5, 10)
    stops = run(cells, np.array([start]), mu)
    assert (stops.status == STOPPED).sum() >= 2
    for k in range(len(mu)):
        stop, x, u = witness(path, 100.0, mu[k], **effects)
        assert np.isnan(stop) == (stops.status[0, k] == LEFT_PROFILE)
        np.testing.assert_allclose(stops.x[0, k], stop, atol=0.1)
        fast = (u > 1.0) & (x < path.x[-1])
        speeds = speeds_along(cells, start, mu[k : k + 1], x[fast])[0]
        np.testing.assert_allclose(speeds, u[fast], rtol=1e-3, atol=5e-3)
