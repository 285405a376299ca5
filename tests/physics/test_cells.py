from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval
from scipy.integrate import quad

from avahazard.physics.cells import SPEEDS, no_resistance
from avahazard.physics.terrain import build_terrain
from tests.physics.paths import cells_of, profile_of, ski_jump

G = 9.81
TERRAIN = build_terrain(ski_jump())


@pytest.mark.parametrize("curvature", [0.0, 1.0])
@pytest.mark.parametrize(("constant", "drag"), [(0.0, 0.0), (1.3, 0.0), (0.0, 0.004), (0.7, 0.01)])
def test_growth_and_drive_are_the_integrals(curvature, constant, drag) -> None:
    """A = exp(2μΔθ - 2dL), B = ∫ exp(2μ(θ₁ - θ) - 2d(s₁ - s)) (2g(tanθ - μ) - 2c/cosθ) dx."""
    cells = cells_of(TERRAIN, constant=constant, drag=drag, curvature=curvature)
    profile = ski_jump()

    def theta(x):
        return -np.arctan(profile.derivatives(x)[1])

    for i in range(0, TERRAIN.n_cells, 19):
        x0, x1 = TERRAIN.x[i], TERRAIN.x[i + 1]
        for mu in (0.15, 0.6, 1.2):

            def exponent(x, mu=mu, x1=x1):
                left = quad(lambda z: 1.0 / np.cos(theta(z)), x, x1)[0]
                turn = curvature * (theta(x1) - theta(x))
                return np.exp(2.0 * mu * turn - 2.0 * drag * left)

            def integrand(x, mu=mu):
                pull = 2.0 * G * (np.tan(theta(x)) - mu) - 2.0 * constant / np.cos(theta(x))
                return exponent(x) * pull

            b = quad(integrand, x0, x1, epsabs=1e-11)[0]
            assert polyval(mu, cells.growth[i]) == pytest.approx(exponent(x0), rel=1e-9)
            assert polyval(mu, cells.drive[i]) == pytest.approx(b, rel=1e-9, abs=1e-8)


def test_blocks_below_lift_stay_on_the_ground() -> None:
    profile = ski_jump()
    cells = cells_of(TERRAIN)
    flying = 0
    for i in np.flatnonzero(cells.lift < np.inf):
        _, slope, second = profile.derivatives(np.linspace(TERRAIN.x[i], TERRAIN.x[i + 1], 50))
        normal_over_cos = G + second / (1.0 + slope**2) * cells.lift[i]
        assert np.min(normal_over_cos) > 0.0
        flying += np.min(normal_over_cos) < 0.1 * G
    assert flying > 10  # and the limit is no lower than it has to be


def test_without_curvature_no_block_leaves_the_ground() -> None:
    assert np.all(cells_of(TERRAIN, curvature=0.0).lift == np.inf)


def test_dip_only_where_the_path_steepens() -> None:
    valley = build_terrain(profile_of(lambda x: (x / 50.0 - 16.0) ** 2, 800.0))
    assert np.all(cells_of(valley).dip == 0.0)
    hill = build_terrain(profile_of(lambda x: 500.0 - (x / 50.0) ** 2, 800.0))
    assert np.all(cells_of(hill).dip > 0.0)


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        ({}, False),
        ({"speed_factor": np.ones(len(SPEEDS))}, False),
        ({"speed_constant": np.zeros(len(SPEEDS))}, False),
        ({"speed_factor": 1.0 / (1.0 + SPEEDS)}, True),
        ({"speed_constant": 0.1 * SPEEDS}, True),
    ],
)
def test_tables_over_speed_count_unless_they_are_neutral(tables, expected) -> None:
    assert cells_of(TERRAIN, **tables).speed_dependent is expected


def test_no_resistance_is_neutral() -> None:
    base = no_resistance(TERRAIN)
    assert base.curvature == 1.0
    assert np.all(base.factor == 1.0)
    for field in (base.offset, base.constant, base.drag):
        np.testing.assert_array_equal(field, np.zeros(TERRAIN.n_cells))


def test_a_cell_that_steepens_in_part_may_dip() -> None:
    wavy = profile_of(lambda x: 500.0 - 0.3 * x + 20.0 * np.cos(x / 90.0), 800.0)
    terrain = build_terrain(wavy)
    cells = cells_of(terrain)
    partly = 0
    for i in range(terrain.n_cells):
        slope = wavy.derivatives(np.linspace(terrain.x[i], terrain.x[i + 1], 200))[1]
        steepens = np.diff(-slope) > 0.0
        if 0.2 < steepens.mean() < 0.8:
            assert cells.dip[i] > 0.0
            partly += 1
    assert partly > 0
