"""Cells where contact changes against very small steps of the equation of motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from avahazard.kernels import kernel
from avahazard.physics.cell_step import BATCH_SIZE, step
from avahazard.physics.contact import bend_inside, step_with_contact
from avahazard.physics.smooth_profile import spline_profile
from avahazard.physics.terrain import build_terrain
from tests.physics import naive
from tests.physics.paths import bowl, cells_of, read_profiles, ski_jump


def follow(profile, terrain, i, mu, w, n=4000, **resistance):
    """w at the end of cell i and the place where N was first zero, by the midpoint rule."""
    x = np.linspace(terrain.x[i], terrain.x[i + 1], 2 * n + 1)
    _, slope, second = profile.derivatives(x)
    h = x[2] - x[0]
    lost = np.full(len(w), np.nan)
    for k in range(n):
        kappa_over_cos = second[2 * k] / (1.0 + slope[2 * k] ** 2)
        off = np.isnan(lost) & (naive.G + kappa_over_cos * w < 0.0)
        lost[off] = x[2 * k]
        half = w + 0.5 * h * naive.rate(mu, w, slope[2 * k], second[2 * k], **resistance)
        w = w + h * naive.rate(mu, half, slope[2 * k + 1], second[2 * k + 1], **resistance)
    return w, lost


@pytest.mark.parametrize("resistance", [{}, {"drag": 0.01, "constant": 0.5, "factor": 0.8}])
def test_ski_jump(resistance) -> None:
    profile = ski_jump()
    check(profile, build_terrain(profile), resistance, 0.1, 0.05)


def test_rough_path(shared_data) -> None:
    x, y = read_profiles(shared_data / "tyrol-profiles" / "profiles.csv")["gar2345"]
    profile = spline_profile(x, y)
    check(profile, build_terrain(profile), {}, 0.02, 0.3)


def check(profile, terrain, resistance, tolerance, place_tolerance) -> None:
    cells = cells_of(terrain, **resistance)
    rng = np.random.default_rng(1)
    mu = rng.uniform(0.15, 0.8, BATCH_SIZE)
    mu[::9] = 1.2
    kinds, slow_ones = set(), 0
    reachable = 2.0 * naive.G * (terrain.y[0] - terrain.y[1:])
    for i in np.flatnonzero(cells.lift < reachable)[::3]:
        w = np.empty((2, BATCH_SIZE))
        w[0] = cells.lift[i] * rng.uniform(0.9, 1.4, BATCH_SIZE)
        w[0, ::9] = rng.uniform(0.0, 10.0)  # slow beside fast: some come to rest
        step(cells, i, mu, w, 0, 1)
        on_ground = w[1].copy()
        held, push, lost = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE), np.full(BATCH_SIZE, np.nan)
        low = step_with_contact(cells, i, mu, w, 0, 1, held, push, lost)
        assert low == bool(np.any(w[1] <= cells.dip[i]))
        slow_ones += low
        w_end, place = follow(profile, terrain, i, mu, w[0].copy(), **resistance)
        np.testing.assert_allclose(w[1], w_end, atol=tolerance)
        both = np.isfinite(lost) & np.isfinite(place)
        np.testing.assert_allclose(lost[both], place[both], atol=place_tolerance)
        untouched = np.maximum(w[0], on_ground) <= cells.lift[i]
        np.testing.assert_array_equal(w[1][untouched], on_ground[untouched])
        assert np.isnan(lost[untouched]).all()
        kinds |= {"ground"} if untouched.any() else set()
        kinds |= {"leaves"} if (lost > terrain.x[i]).any() else set()
        kinds |= {"flies"} if (lost == terrain.x[i]).any() else set()
    assert kinds == {"ground", "leaves", "flies"}
    assert slow_ones > 0


@kernel
def bends(cells, i, places, out):
    """`bend_inside` at each of the places, as compiled code alone can call it."""
    for k in range(len(places)):
        out[k] = bend_inside(cells, i, places[k])


@pytest.mark.parametrize("profile", [ski_jump(), bowl()], ids=["jump", "bowl"])
def test_the_bend_within_a_cell_is_that_of_the_ground(profile) -> None:
    terrain = build_terrain(profile)
    cells = cells_of(terrain)
    share = np.linspace(0.0, 1.0, 9)
    for i in range(0, terrain.n_cells, 3):
        found = np.empty(len(share))
        bends(cells, i, share, found)
        x = terrain.x[i] + share * (terrain.x[i + 1] - terrain.x[i])
        _, slope, second = profile.derivatives(x)
        ground = -second / (1.0 + slope**2)
        np.testing.assert_allclose(found, ground, atol=0.03 * np.ptp(terrain.bend))
        ends = slice(i, i + 2)
        cubic = CubicHermiteSpline(cells.x[ends], cells.slope[ends], cells.steepening[ends])
        np.testing.assert_allclose(found, cubic(x, 1) / (1.0 + cubic(x) ** 2), rtol=1e-9)
