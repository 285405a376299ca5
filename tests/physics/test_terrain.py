from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from avahazard.physics.terrain import MAX_CELL_M, MAX_TURN, build_terrain
from tests.physics.paths import bowl, read_profiles, ski_jump, spline_profile


@pytest.mark.parametrize("profile", [bowl(), ski_jump()], ids=["bowl", "jump"])
def test_cells_are_short_and_turn_little(profile) -> None:
    terrain = build_terrain(profile)
    assert np.max(np.diff(terrain.x)) <= MAX_CELL_M + 1e-9
    assert np.max(np.abs(np.diff(terrain.theta))) <= MAX_TURN
    assert terrain.x[0] == profile.x_min
    assert terrain.x[-1] == profile.x_max
    assert np.all(np.diff(terrain.x) > 0.0)


def test_rough_paths_also_turn_little(shared_data) -> None:
    for x, y in read_profiles(shared_data / "tyrol-profiles" / "profiles.csv").values():
        profile = spline_profile(x, y)
        terrain = build_terrain(profile)
        assert np.max(np.abs(np.diff(terrain.theta))) <= MAX_TURN
        assert np.isin(profile.knots, terrain.x).all()


def test_breaks_are_nodes_and_others_are_not() -> None:
    breaks = np.array([100.0, 731.7, 731.8])
    terrain = build_terrain(bowl(), breaks)
    for place in breaks:
        assert terrain.x[terrain.node(place)] == place
    with pytest.raises(ValueError, match="not a node"):
        terrain.node(101.25)
    with pytest.raises(ValueError, match="not a node"):
        terrain.node(1e6)


def test_breaks_outside_of_the_profile_change_nothing() -> None:
    np.testing.assert_array_equal(
        build_terrain(bowl(), np.array([-5.0, 9e9])).x, build_terrain(bowl()).x
    )


def test_geometry_is_that_of_the_profile() -> None:
    profile = ski_jump()
    terrain = build_terrain(profile)
    y, slope, second = profile.derivatives(terrain.x)
    np.testing.assert_allclose(terrain.y, y)
    np.testing.assert_allclose(terrain.theta, -np.arctan(slope))
    # dθ/dx = -κ/cosθ, κ = f''/(1 + f'²)^{3/2}
    kappa = second / (1.0 + slope**2) ** 1.5
    np.testing.assert_allclose(terrain.bend, -kappa / np.cos(terrain.theta), atol=1e-15)
    _, slope, second = profile.derivatives(terrain.gauss_x)
    np.testing.assert_allclose(terrain.gauss_theta, -np.arctan(slope))
    np.testing.assert_allclose(terrain.gauss_bend, -second / (1.0 + slope**2), atol=1e-15)


def test_arc_length_is_the_integral() -> None:
    profile = ski_jump()
    terrain = build_terrain(profile)

    def length(a: float, b: float) -> float:
        return quad(lambda x: np.hypot(1.0, profile.derivatives(x)[1]), a, b, epsabs=1e-10)[0]

    total = sum(length(*ends) for ends in np.reshape(np.repeat(terrain.x, 2)[1:-1], (-1, 2)))
    assert terrain.s[-1] == pytest.approx(total, abs=1e-7)
    for i in (0, terrain.n_cells // 2, terrain.n_cells - 1):
        assert np.sum(terrain.weight[i]) == pytest.approx(terrain.x[i + 1] - terrain.x[i])
        for k in range(6):
            part = length(terrain.x[i], terrain.gauss_x[i, k])
            assert terrain.gauss_s[i, k] - terrain.s[i] == pytest.approx(part, abs=1e-8)
