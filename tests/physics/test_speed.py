"""Speeds along a path, and of what is brought to rest where no one friction stops a block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.physics.block import run
from avahazard.physics.cells import GRAVITY, SPEEDS, Cells, Resistance, build_cells, no_resistance
from avahazard.physics.smooth_profile import legendre_profile
from avahazard.physics.speed import TRIED, _at, carried, speeds_along, squares_to_rest
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


def resistances(terrain) -> dict[str, Resistance]:
    plain = no_resistance(terrain)
    dragging = replace(plain, drag=np.full(terrain.n_cells, 0.002))
    weak = replace(plain, speed_factor=0.7 + 0.3 / (1.0 + SPEEDS / 10.0))
    return {"plain": plain, "drag": dragging, "by speed": weak}


@pytest.mark.parametrize("name", ["plain", "drag", "by speed"])
def test_where_a_block_stops_it_is_that_block(name: str) -> None:
    terrain = terrain_of(bowl())
    cells = build_cells(terrain, resistances(terrain)[name])
    start, mu = terrain.node(RELEASE_M), np.array([0.55])
    stop = float(run(cells, np.array([start]), mu).x[0, 0])
    x = np.linspace(RELEASE_M + 50.0, stop - 20.0, 12)
    square = squares_to_rest(cells, start, stop, x)
    block = speeds_along(cells, start, mu, x)[0]
    np.testing.assert_allclose(np.sqrt(square), block, rtol=0.04, atol=0.2)


def test_without_curvature_it_is_the_energy_line() -> None:
    """u² = 2 g (fall - mean friction times reach), wherever the ground lies."""
    profile = ski_jump()
    terrain = terrain_of(profile)
    flat = replace(no_resistance(terrain), curvature=0.0)
    cells, start = build_cells(terrain, flat), terrain.node(RELEASE_M)
    stop = float(profile.x_max) - 100.0
    x = terrain.x[(terrain.x > RELEASE_M) & (terrain.x < stop)]
    fall = profile.height(RELEASE_M) - profile.height(x)
    whole = profile.height(RELEASE_M) - profile.height(stop)
    friction = float(whole) / (stop - RELEASE_M)
    expected = 2.0 * GRAVITY * (fall - friction * (x - RELEASE_M))
    found = squares_to_rest(cells, start, stop, x)
    np.testing.assert_allclose(found, expected, atol=0.01 * np.max(np.abs(expected)))


def naive_carried(cells: Cells, start: int, mu: np.ndarray) -> np.ndarray:
    """One cell after the other, by the series in powers of friction."""
    square = [np.zeros(len(mu))]
    powers = np.arange(cells.growth.shape[1])
    for i in range(start, len(cells.length)):
        moving = np.maximum(square[-1], 0.0)
        friction = mu * cells.factor[i] * np.interp(np.sqrt(moving), SPEEDS, cells.speed_factor)
        term = (friction + cells.offset[i])[:, None] ** powers
        push = 2.0 * np.interp(np.sqrt(moving), SPEEDS, cells.speed_constant) * cells.length[i]
        step = (term @ cells.growth[i] - 1.0) * moving + term @ cells.drive[i] - push
        square.append(square[-1] + step)
    return np.array(square)


@pytest.mark.parametrize("name", ["plain", "drag", "by speed"])
def test_it_is_carried_on_as_its_slow_twin(name: str) -> None:
    terrain = terrain_of(bowl())
    cells = build_cells(terrain, resistances(terrain)[name])
    start = terrain.node(RELEASE_M)
    expected = naive_carried(cells, start, TRIED)
    np.testing.assert_allclose(carried(cells, start, TRIED), expected, rtol=1e-9, atol=1e-6)


def test_it_is_carried_on_past_its_stop() -> None:
    terrain = terrain_of(bowl())
    cells, start = build_cells(terrain, no_resistance(terrain)), terrain.node(RELEASE_M)
    square = carried(cells, start, TRIED)
    assert square.shape == (len(cells.x) - start, len(TRIED))
    assert np.all(np.diff(square[-1]) < 0.0)
    assert np.min(square) < 0.0 < np.max(square[-1])


def test_a_stop_beyond_all_frictions_takes_the_largest() -> None:
    """At 72° not even the largest friction brings a block to rest."""
    x = np.linspace(0.0, 300.0, 61)
    terrain = terrain_of(legendre_profile(x, 2000.0 - 3.0 * x, penalty=0.0))
    cells, start = build_cells(terrain, no_resistance(terrain)), terrain.node(RELEASE_M)
    square = squares_to_rest(cells, start, float(cells.x[-2]), cells.x[[start + 1, -2]])
    largest = carried(cells, start, TRIED)[[1, -2], -1]
    np.testing.assert_allclose(square, largest)
    assert largest[-1] > 100.0


def test_squares_between_nodes_lie_on_straight_lines() -> None:
    node_x, square = np.array([0.0, 10.0, 30.0]), np.array([[1.0, 4.0], [5.0, 2.0], [3.0, 0.0]])
    x = np.array([-5.0, 0.0, 4.0, 10.0, 25.0, 30.0, 40.0])
    expected = np.column_stack([np.interp(x, node_x, column) for column in square.T])
    np.testing.assert_allclose(_at(square, node_x, x), expected, atol=1e-12)
