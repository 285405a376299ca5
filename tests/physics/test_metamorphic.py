"""What a change of the path does to where the block stops, whatever the path is."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.block import run
from avahazard.physics.runout_curve import MU
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from tests.physics.paths import RELEASE_M, cells_of, terrain_of

X = np.linspace(0.0, 2400.0, 121)
Y = 2000.0 - 1000.0 * (1.0 - np.exp(-X / 800.0)) + 25.0 * np.sin(X / 260.0)


def stops(smooth: SmoothProfile, scale: float = 1.0) -> tuple[np.ndarray, ...]:
    """x and y of the stop, and status, for each friction."""
    terrain = terrain_of(smooth, RELEASE_M * scale, max_cell=20.0 * scale)
    starts = np.array([terrain.node(RELEASE_M * scale)])
    found = run(cells_of(terrain), starts, MU)
    return found.x[0], found.y[0], found.status[0]


@pytest.mark.parametrize("method", ["legendre", "spline"])
@pytest.mark.parametrize("up", [-500.0, 3000.0])
def test_a_path_that_is_lifted_stops_the_block_at_the_same_place(method: str, up: float) -> None:
    x, y, status = stops(smooth_profile(X, Y, np.full(len(X), 1.0), method))  # type: ignore[arg-type]
    lifted = stops(smooth_profile(X, Y + up, np.full(len(X), 1.0), method))  # type: ignore[arg-type]
    np.testing.assert_array_equal(lifted[2], status)
    np.testing.assert_allclose(lifted[0], x, atol=1e-3)
    np.testing.assert_allclose(lifted[1], y + up, atol=1e-3)


def test_a_path_that_begins_elsewhere_stops_the_block_as_far_from_its_top() -> None:
    sigma = np.full(len(X), 1.0)
    x, y, status = stops(smooth_profile(X, Y, sigma, "spline"))
    terrain = terrain_of(smooth_profile(X + 700.0, Y, sigma, "spline"), RELEASE_M + 700.0)
    found = run(cells_of(terrain), np.array([terrain.node(RELEASE_M + 700.0)]), MU)
    np.testing.assert_array_equal(found.status[0], status)
    np.testing.assert_allclose(found.x[0] - 700.0, x, atol=1e-3)
    np.testing.assert_allclose(found.y[0], y, atol=1e-3)


@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_a_path_of_another_size_stops_the_block_at_its_likeness(scale: float) -> None:
    """Coulomb friction knows no length: where it stops, and whether it does, scales."""
    x, y, status = stops(smooth_profile(X, Y, method="legendre"))
    large = stops(smooth_profile(scale * X, scale * Y, method="legendre"), scale)
    np.testing.assert_array_equal(large[2], status)
    np.testing.assert_allclose(large[0] / scale, x, atol=0.05)
    np.testing.assert_allclose(large[1] / scale, y, atol=0.05)
