"""What a change of the path does to where the block stops, whatever the path is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from avahazard.physics.block import run
from avahazard.physics.runout_curve import MU
from avahazard.physics.smooth_profile import SmoothProfile, legendre_profile
from tests.physics.paths import RELEASE_M, cells_of, spline_profile, terrain_of

X = np.linspace(0.0, 2400.0, 121)
Y = 2000.0 - 1000.0 * (1.0 - np.exp(-X / 800.0)) + 25.0 * np.sin(X / 260.0)


def stops(smooth: SmoothProfile, scale: float = 1.0) -> tuple[np.ndarray, ...]:
    """x and y of the stop, and status, for each friction."""
    terrain = terrain_of(smooth, RELEASE_M * scale, max_cell=20.0 * scale)
    starts = np.array([terrain.node(RELEASE_M * scale)])
    found = run(cells_of(terrain), starts, MU)
    return found.x[0], found.y[0], found.status[0]


@pytest.mark.parametrize("regularised", [legendre_profile, lambda x, y: spline_profile(x, y, 1.0)])
@pytest.mark.parametrize("up", [-500.0, 3000.0])
def test_a_path_that_is_lifted_stops_the_block_at_the_same_place(
    regularised: Callable[[np.ndarray, np.ndarray], SmoothProfile], up: float
) -> None:
    x, y, status = stops(regularised(X, Y))
    lifted = stops(regularised(X, Y + up))
    np.testing.assert_array_equal(lifted[2], status)
    np.testing.assert_allclose(lifted[0], x, atol=1e-3)
    np.testing.assert_allclose(lifted[1], y + up, atol=1e-3)


def test_a_path_that_begins_elsewhere_stops_the_block_as_far_from_its_top() -> None:
    x, y, status = stops(spline_profile(X, Y, 1.0))
    terrain = terrain_of(spline_profile(X + 700.0, Y, 1.0), RELEASE_M + 700.0)
    found = run(cells_of(terrain), np.array([terrain.node(RELEASE_M + 700.0)]), MU)
    np.testing.assert_array_equal(found.status[0], status)
    np.testing.assert_allclose(found.x[0] - 700.0, x, atol=1e-3)
    np.testing.assert_allclose(found.y[0], y, atol=1e-3)


@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_a_path_of_another_size_stops_the_block_at_its_likeness(scale: float) -> None:
    """Coulomb friction knows no length: where it stops, and whether it does, scales."""
    x, y, status = stops(legendre_profile(X, Y))
    large = stops(legendre_profile(scale * X, scale * Y), scale)
    np.testing.assert_array_equal(large[2], status)
    np.testing.assert_allclose(large[0] / scale, x, atol=0.05)
    np.testing.assert_allclose(large[1] / scale, y, atol=0.05)
