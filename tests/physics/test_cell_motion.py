"""Accelerations at the ends of a cell, against equation 2.3."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.cell_motion import end_accelerations
from tests.physics.paths import bowl, cells_of, terrain_of

FRICTION, COHESION, DRAG, G = 0.4, 0.7, 0.004, 9.81


@pytest.mark.parametrize("w", [0.0, 900.0])
def test_accelerations_are_those_of_the_equation(w: float) -> None:
    profile = bowl()
    terrain = terrain_of(profile)
    cells = cells_of(terrain, constant=COHESION, drag=DRAG, factor=0.9, offset=0.02)
    _, slope, bending = profile.derivatives(terrain.x)
    for i in range(0, terrain.n_cells, 9):
        for node, found in zip(
            (i, i + 1), end_accelerations(cells, i, FRICTION, w, w), strict=True
        ):
            angle = -np.arctan(slope[node])
            curvature = bending[node] / (1.0 + slope[node] ** 2) ** 1.5
            normal = max(0.0, G * np.cos(angle) + curvature * w)
            resisting = (0.9 * FRICTION + 0.02) * normal + COHESION + DRAG * w
            along = 2.0 * (G * np.sin(angle) - resisting)
            assert found == pytest.approx(along / np.cos(angle), rel=1e-9, abs=1e-9)
