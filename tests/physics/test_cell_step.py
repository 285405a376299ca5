"""The step in vectors against its definition, and contact that changes against tiny steps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval
from scipy.interpolate import CubicHermiteSpline

from avahazard.kernels import kernel
from avahazard.physics.block import (
    BATCH_SIZE,
    LANES,
    bend_inside,
    first_of_batch,
    step,
    step_by_speed,
    step_with_contact,
)
from avahazard.physics.cell_motion import at_speed
from avahazard.physics.cells import SPEEDS
from avahazard.physics.terrain import build_terrain
from tests.physics import naive
from tests.physics.paths import bowl, cells_of, read_profiles, ski_jump, spline_profile

TERRAIN = build_terrain(ski_jump())
FRICTION = np.random.default_rng(2).uniform(0.1, 1.3, BATCH_SIZE)


def before(cell: int) -> np.ndarray:
    """Speeds before a cell; the same whatever other tests run."""
    rng = np.random.default_rng([2, cell])
    w = np.empty((2, BATCH_SIZE))
    w[0] = rng.uniform(0.0, 3000.0, BATCH_SIZE) * (rng.uniform(size=BATCH_SIZE) > 0.2)
    w[0, 3] = np.nan
    return w


def test_step_is_growth_times_w_plus_drive() -> None:
    cells = cells_of(TERRAIN, factor=0.9, offset=0.05, drag=0.003)
    seen = set()
    for i in range(TERRAIN.n_cells):
        w = before(i)
        low, high = step(cells, i, FRICTION, w, 0, 1)
        m = 0.9 * FRICTION + 0.05
        expected = polyval(m, cells.growth[i]) * w[0] + polyval(m, cells.drive[i])
        np.testing.assert_allclose(w[1], expected, rtol=1e-12, atol=1e-10)
        assert low == bool(np.any(expected <= cells.dip[i]))
        assert high == bool(np.any((expected > cells.lift[i]) | (w[0] > cells.lift[i])))
        seen |= {(low, high)}
    assert {(True, False), (True, True)} <= seen


def test_step_by_speed_takes_resistance_at_the_mean_w() -> None:
    factor, push = 0.5 + 0.5 / (1.0 + SPEEDS / 9.0), 0.02 * SPEEDS
    cells = cells_of(TERRAIN, speed_factor=factor, speed_constant=push, offset=0.01)
    for i in range(0, TERRAIN.n_cells, 7):
        w = before(i)
        held, push_of = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE)
        step_by_speed(cells, i, FRICTION, w, 0, 1, held, push_of, BATCH_SIZE)
        w1 = w[0].copy()
        for _ in range(60):
            u = np.sqrt(0.5 * (w[0] + np.maximum(w1, 0.0)))
            m = FRICTION * np.interp(u, SPEEDS, factor) + 0.01
            w1 = polyval(m, cells.growth[i]) * w[0] + polyval(m, cells.drive[i])
            w1 -= 2.0 * np.interp(u, SPEEDS, push) * cells.length[i]
        fast = w[0] > 800.0  # where three rounds suffice
        np.testing.assert_allclose(w[1][fast], w1[fast], rtol=2e-4)
        assert np.isnan(w[1, 3])


def test_a_friction_that_is_the_same_at_all_speeds_steps_as_if_it_knew_none() -> None:
    cells = cells_of(TERRAIN, speed_factor=np.ones(len(SPEEDS)), offset=0.01)
    most = 3.0 * FRICTION
    told = False
    for i in range(TERRAIN.n_cells):
        w = before(i)
        step_by_speed(
            cells, i, most, w, 0, 1, np.empty(BATCH_SIZE), np.empty(BATCH_SIZE), BATCH_SIZE
        )
        m = most + 0.01
        expected = polyval(m, cells.growth[i]) * w[0] + polyval(m, cells.drive[i])
        np.testing.assert_allclose(w[1], expected, rtol=1e-12, atol=1e-10)
        shorter = polyval(m, cells.drive[i, :-1])
        told = told or bool(np.any(np.abs(polyval(m, cells.drive[i]) - shorter) > 1e-8))
    # The last of its powers counts somewhere.
    assert told


@pytest.mark.parametrize("push", [0.0 * SPEEDS, 0.02 * SPEEDS])
def test_blocks_at_rest_behind_the_others_may_be_left_out(push: np.ndarray) -> None:
    cells = cells_of(
        TERRAIN, speed_factor=0.5 + 0.5 / (1.0 + SPEEDS / 9.0), speed_constant=push, offset=0.01
    )
    w = before(5)
    w[0, LANES - 2 :] = np.nan
    n_first = first_of_batch(w, 0)
    assert n_first == LANES
    ends = []
    for n in (n_first, BATCH_SIZE):
        memory = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE)
        flags = step_by_speed(cells, 5, FRICTION, w, 0, 1, *memory, n)
        ends.append((flags, w[1].copy()))
    assert ends[0][0] == ends[1][0]
    np.testing.assert_array_equal(ends[0][1], ends[1][1])


def test_no_block_moves() -> None:
    assert first_of_batch(np.full((1, BATCH_SIZE), np.nan), 0) == 0


@pytest.mark.parametrize("speed", [0.0, 0.3, 7.25, 149.9, 150.0, 400.0])
def test_at_speed_interpolates_the_table(speed: float) -> None:
    table = np.cos(SPEEDS / 20.0)
    assert at_speed(table, speed**2) == pytest.approx(np.interp(speed, SPEEDS, table))
    assert at_speed(table, np.nan) == table[-1]
    assert at_speed(table, -4.0) == table[0]


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
