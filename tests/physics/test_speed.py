from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.block import run
from avahazard.physics.speed import speeds_along
from tests.physics.naive import small_steps
from tests.physics.paths import RELEASE_M, bowl, cells_of, ski_jump, terrain_of

MU = np.linspace(0.2, 0.95, 40)


@pytest.mark.parametrize("profile", [bowl(), ski_jump()], ids=["bowl", "jump"])
def test_speeds_are_those_of_small_steps(profile) -> None:
    terrain = terrain_of(profile)
    x = np.linspace(RELEASE_M + 5.0, profile.x_max, 200)
    speeds = speeds_along(cells_of(terrain), terrain.node(RELEASE_M), MU, x)
    _, places, w = small_steps(profile, RELEASE_M, MU)
    for k in range(len(MU)):
        expected = np.sqrt(np.interp(x, places, w[:, k]))
        fast = expected > 3.0
        np.testing.assert_allclose(speeds[k][fast], expected[fast], rtol=1e-3)
        assert np.all(speeds[k][~fast] < 3.2)


def test_zero_before_the_release_past_the_stop_and_off_the_path() -> None:
    profile = bowl()
    terrain = terrain_of(profile)
    cells, start = cells_of(terrain), terrain.node(RELEASE_M)
    mu = np.array([0.3, 0.6, 3.0])
    stop = run(cells, np.array([start]), mu).x[0, 1]
    x = np.array([stop + 0.01, 50.0, stop - 0.01, profile.x_max + 1.0, RELEASE_M, -1.0, 1e3])
    speeds = speeds_along(cells, start, mu, x)
    np.testing.assert_array_equal(speeds[:, [1, 3, 4, 5]], 0.0)
    np.testing.assert_array_equal(speeds[2], 0.0)
    assert speeds[1, 0] == 0.0
    assert 0.0 < speeds[1, 2] < 1.0
    assert speeds[0, 6] > speeds[1, 6] > 0.0


def test_the_order_of_places_and_frictions_is_free() -> None:
    terrain = terrain_of(ski_jump())
    cells, start = cells_of(terrain), terrain.node(RELEASE_M)
    x = np.linspace(0.0, 1500.0, 77)
    rng = np.random.default_rng(3)
    places, frictions = rng.permutation(len(x)), rng.permutation(len(MU))
    base = speeds_along(cells, start, MU, x)
    mixed = speeds_along(cells, start, MU[frictions], x[places])
    np.testing.assert_array_equal(mixed, base[np.ix_(frictions, places)])


def test_release_at_the_end_of_the_path() -> None:
    cells = cells_of(terrain_of(bowl()))
    speeds = speeds_along(cells, len(cells.length), MU, np.array([100.0, cells.x[-1]]))
    np.testing.assert_array_equal(speeds, 0.0)
