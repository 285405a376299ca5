"""Forces of the state: their curves, and the block that runs with them."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from avahazard.effects.catalogue import definition
from avahazard.effects.effect import Facts, MotionEffect
from avahazard.effects.motion import N_GRID, STATES, _basis
from avahazard.effects.site import Site
from avahazard.physics.cells import SPEEDS, Resistance, no_resistance
from avahazard.physics.speed import speeds_along
from tests.effects.examples import columns, sites
from tests.physics.naive import rate

KEYS = ("force:speed", *(f"force:{state}" for state in STATES))


@cache
def site() -> Site:
    return sites()[0]


def facts_of(key: str) -> Facts:
    found = definition(key).facts(columns(), sites())
    return dict(json.loads(json.dumps(found)))


def effect(key: str) -> MotionEffect:
    built = definition(key).build(facts_of(key))
    assert isinstance(built, MotionEffect)
    return built


def some(n: int) -> Resistance:
    return Resistance(np.full(n, 1.1), np.full(n, 0.02), np.full(n, 0.3), np.full(n, 0.001))


@pytest.mark.parametrize("key", KEYS)
def test_curves_are_orthonormal_over_the_range_of_the_state(key: str) -> None:
    facts, rests = facts_of(key), key == "force:speed"
    low, high = facts["low"], facts["high"]
    grid = np.linspace(low, high, N_GRID)
    curves = _basis(facts, grid, rests=rests)
    n = facts["degree"]
    assert curves.shape == (N_GRID, n)
    np.testing.assert_allclose(curves.T @ curves / N_GRID, np.eye(n), atol=1e-9)
    # The first goes in a line with the state, and up; the others bend.
    line = np.polyfit(grid, curves[:, 0], 1)
    np.testing.assert_allclose(curves[:, 0], np.polyval(line, grid), atol=1e-9)
    assert line[0] > 0.0
    if rests:
        np.testing.assert_array_equal(_basis(facts, np.zeros(1), rests=True), 0.0)
    else:
        np.testing.assert_allclose(curves.mean(axis=0), 0.0, atol=1e-9)
    beyond = _basis(facts, np.array([low - 9.0, low, high, high + 9.0]), rests=rests)
    np.testing.assert_allclose(beyond[[0, 3]], beyond[[1, 2]])


@pytest.mark.parametrize("key", KEYS)
def test_a_power_of_the_state_is_among_the_curves(key: str) -> None:
    facts, rests = facts_of(key), key == "force:speed"
    at = np.linspace(facts["low"], facts["high"], 40)
    columns_ = np.column_stack([_basis(facts, at, rests=rests), np.ones(len(at))])
    left = at**2 - columns_ @ np.linalg.lstsq(columns_, at**2, rcond=None)[0]
    assert np.max(np.abs(left)) < 1e-6 * np.max(at**2)


@pytest.mark.parametrize("state", STATES)
def test_friction_of_each_cell_is_that_of_its_state(state: str) -> None:
    made, terrain = effect(f"force:{state}"), site().terrain
    values = np.array([0.03, -0.02, 0.01])[: len(made.parameters)]
    after = made.resistance(site(), some(terrain.n_cells), values)
    middle = terrain.middle_x
    slope, second = (site().smooth.derivatives(middle)[k] for k in (1, 2))
    by_hand = {
        "slope": np.degrees(-np.arctan(slope)),
        "elevation": site().smooth.height(middle),
        "curvature": 1000.0 * second / (1.0 + slope**2) ** 1.5,
        "distance": middle - terrain.x[0],
    }[state]
    facts = facts_of(f"force:{state}")
    np.testing.assert_allclose(
        after.offset - 0.02, _basis(facts, by_hand, rests=False) @ values, atol=1e-3
    )
    assert np.ptp(after.offset) > 0.01
    for name in ("factor", "constant", "drag"):
        np.testing.assert_array_equal(getattr(after, name), getattr(some(terrain.n_cells), name))


def test_a_force_of_speed_adds_to_another() -> None:
    made = effect("force:speed")
    values = np.array([0.5, -0.3, 0.2])[: len(made.parameters)]
    once = made.resistance(site(), no_resistance(site().fine_terrain), values)
    assert once.speed_constant[0] == 0.0
    assert once.speed_constant.shape == SPEEDS.shape
    twice = made.resistance(site(), once, values)
    np.testing.assert_allclose(twice.speed_constant, 2.0 * once.speed_constant)


@pytest.mark.parametrize("key", KEYS)
def test_the_block_feels_the_force(key: str) -> None:
    """Equation 2.3 in small steps, with the force as a curve over the state."""
    made, smooth = effect(key), site().smooth
    values = np.array([[p.prior_sd, -0.7 * p.prior_sd] for p in made.parameters])
    values = values[:, 0] * np.where(np.arange(len(values)) % 2, -0.7, 1.0)
    facts, mu, start = facts_of(key), 0.3, float(site().release_x[1])
    places = np.array([500.0, 700.0, 900.0])

    def pull(x: float, w: np.ndarray) -> np.ndarray:
        _, slope, second = (float(v[0]) for v in smooth.derivatives(np.array([x])))
        states = {
            "force:slope": np.degrees(-np.arctan(slope)),
            "force:elevation": float(smooth.height(np.array([x]))[0]),
            "force:curvature": 1000.0 * second / (1.0 + slope**2) ** 1.5,
            "force:distance": x - site().terrain.x[0],
        }
        if key == "force:speed":
            speed = np.sqrt(np.maximum(w, 0.0))
            return rate(mu, w, slope, second, constant=_basis(facts, speed, rests=True) @ values)
        return rate(
            mu,
            w,
            slope,
            second,
            offset=_basis(facts, np.array([states[key]]), rests=False) @ values,
        )

    slow = solve_ivp(pull, (start, 900.0), [0.0], t_eval=places, rtol=1e-6, max_step=5.0)
    terrain = site().fine_terrain if key == "force:speed" else site().terrain
    cells = site().cells(made.resistance(site(), no_resistance(terrain), values))
    at = int(np.searchsorted(cells.x, start))
    fast = speeds_along(cells, at, np.array([mu]), places)[0]
    bare = speeds_along(site().cells(no_resistance(terrain)), at, np.array([mu]), places)[0]
    np.testing.assert_allclose(fast, np.sqrt(slow.y[0]), rtol=3e-3)
    assert np.max(np.abs(fast - bare)) > 0.5
