from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avahazard.physics.block import LEFT_PROFILE, NOT_RELEASED, STOPPED, run
from avahazard.physics.cells import SPEEDS, no_resistance
from tests.physics.naive import small_steps
from tests.physics.paths import (
    RELEASE_M,
    bowl,
    cells_of,
    profile_of,
    ski_jump,
    spline_profile,
    terrain_of,
)

MU = np.linspace(0.2, 0.95, 40)
BOWL, JUMP = bowl(), ski_jump()


def run_from(profile, mu=MU, release=RELEASE_M, max_cell=20.0, **resistance):
    terrain = terrain_of(profile, release, max_cell=max_cell)
    return run(cells_of(terrain, **resistance), np.array([terrain.node(release)]), mu)


def fields(terrain, **resistance):
    """Resistance that holds below x = 700 m only, so that it begins within the run."""
    below = terrain.middle_x > 700.0
    neutral = {"factor": 1.0, "offset": 0.0, "constant": 0.0, "drag": 0.0}
    return {
        name: np.where(below, value, neutral[name]) if name in neutral else value
        for name, value in resistance.items()
    }


EFFECTS = [
    {},
    {"drag": 0.005},
    {"constant": 0.4},
    {"factor": 0.8, "offset": 0.05},
    {"curvature": 0.0, "drag": 0.002},
]


@pytest.mark.parametrize("effects", EFFECTS, ids=lambda e: " ".join(e) or "none")
@pytest.mark.parametrize("profile", [BOWL, JUMP], ids=["bowl", "jump"])
def test_stops_where_small_steps_stop(profile, effects) -> None:
    terrain = terrain_of(profile)
    cells = cells_of(terrain, **fields(terrain, **effects))
    stops = run(cells, np.array([terrain.node(RELEASE_M)]), MU)
    resistance = replace(no_resistance(terrain), **fields(terrain, **effects))
    expected, _, _ = small_steps(profile, RELEASE_M, MU, terrain, resistance, step=0.2)
    np.testing.assert_array_equal(stops.status[0] == LEFT_PROFILE, np.isnan(expected))
    assert (stops.status == STOPPED).any()
    np.testing.assert_allclose(stops.x[0], expected, atol=0.02)
    np.testing.assert_allclose(stops.y[0], profile.height(stops.x[0]), atol=1e-3)


@pytest.mark.parametrize(
    "tables",
    [{"speed_factor": 0.5 + 0.5 / (1.0 + SPEEDS / 10.0)}, {"speed_constant": 0.01 * SPEEDS}],
    ids=["factor", "constant"],
)
@pytest.mark.parametrize("profile", [BOWL, JUMP], ids=["bowl", "jump"])
def test_tables_over_speed(profile, tables) -> None:
    terrain = terrain_of(profile, max_cell=5.0)
    stops = run(cells_of(terrain, **tables), np.array([terrain.node(RELEASE_M)]), MU)
    resistance = replace(no_resistance(terrain), **tables)
    expected, _, _ = small_steps(profile, RELEASE_M, MU, terrain, resistance, step=0.2)
    np.testing.assert_array_equal(stops.status[0] == LEFT_PROFILE, np.isnan(expected))
    assert profile is JUMP or np.count_nonzero(stops.status == STOPPED) > 8
    np.testing.assert_allclose(stops.x[0], expected, atol=0.5)


def test_without_curvature_friction_is_fall_over_length() -> None:
    terrain = terrain_of(BOWL)
    stops = run(cells_of(terrain, curvature=0.0), np.array([terrain.node(RELEASE_M)]), MU)
    x = stops.x[stops.status == STOPPED]
    fall = BOWL.height(RELEASE_M) - BOWL.height(x)
    assert len(x) > 15
    np.testing.assert_allclose(fall / (x - RELEASE_M), MU[stops.status[0] == STOPPED], atol=1e-9)


def test_statuses() -> None:
    stops = run_from(BOWL, np.array([0.05, 0.5, 3.0]))
    np.testing.assert_array_equal(stops.status[0], [LEFT_PROFILE, STOPPED, NOT_RELEASED])
    assert np.isnan([stops.x[0, 0], stops.y[0, 0]]).all()
    assert RELEASE_M < stops.x[0, 1] < BOWL.x_max
    assert stops.x[0, 2] == RELEASE_M
    assert stops.y[0, 2] == BOWL.height(RELEASE_M)
    assert np.isnan(stops.lift_off_x).all()


def test_friction_of_exactly_the_slope_holds_the_block() -> None:
    terrain = terrain_of(BOWL)
    cells = cells_of(terrain)
    start = terrain.node(RELEASE_M)
    slope = cells.slope[start]
    mu = np.array([np.nextafter(slope, 0.0) - 1e-12, slope, np.nextafter(slope, 9.0)])
    status = run(cells, np.array([start]), mu).status[0]
    assert status[0] != NOT_RELEASED
    np.testing.assert_array_equal(status[1:], NOT_RELEASED)


def test_cohesion_also_holds_the_block() -> None:
    terrain = terrain_of(BOWL)
    start = terrain.node(RELEASE_M)
    slope = float(np.tan(terrain.theta[start]))
    needed = 9.81 * np.cos(terrain.theta[start]) * (slope - 0.5)
    for constant, status in ((0.999 * needed, STOPPED), (1.001 * needed, NOT_RELEASED)):
        cells = cells_of(terrain, constant=constant)
        assert run(cells, np.array([start]), np.array([0.5])).status[0, 0] == status


def test_release_in_a_hollow_or_at_the_end_stays_there() -> None:
    hollow = profile_of(lambda x: 900.0 - 0.2 * x + 60.0 * np.cos(x / 150.0), 1500.0)
    lowest = float(np.argmin(hollow.height(np.arange(0.0, 800.0)))) + 5.0
    stops = run_from(hollow, np.array([0.01, 0.3]), lowest)
    np.testing.assert_array_equal(stops.status, NOT_RELEASED)
    np.testing.assert_array_equal(stops.x, lowest)
    cells = cells_of(terrain_of(hollow))
    at_end = run(cells, np.array([len(cells.length)]), np.array([0.01]))
    assert at_end.status[0, 0] == NOT_RELEASED
    assert at_end.x[0, 0] == hollow.x_max


def test_counter_slope_stops_what_reaches_it() -> None:
    valley = profile_of(lambda x: (x - 800.0) ** 2 / 1600.0, 1600.0)
    mu = np.array([0.1, 0.2])
    stops = run_from(valley, mu, 0.0, curvature=0.0)
    # Energy line: 400 - x μ = (x - 800)² / 1600, beyond the lowest point.
    np.testing.assert_allclose(stops.x[0], 1600.0 * (1.0 - mu), atol=1e-3)


def test_a_crest_within_a_cell_holds_what_barely_fails_to_cross_it() -> None:
    """Both ends of the cell would be passed at speed; the energy line meets the ground between."""
    hill = profile_of(lambda x: 900.0 - 0.2 * x + 60.0 * np.cos(x / 150.0), 1300.0)
    release = 300.0
    terrain = terrain_of(hill, release)
    cells = cells_of(terrain, curvature=0.0)
    start = np.array([terrain.node(release)])

    def mean_slope(x):
        return (hill.height(np.array([release]))[0] - hill.height(x)) / (x - release)

    at_nodes = mean_slope(terrain.x[start[0] + 1 :])
    fine = np.linspace(700.0, 1000.0, 300_001)
    crossing = np.min(mean_slope(fine))  # the friction that just crosses
    ends = np.min(at_nodes[np.abs(terrain.x[start[0] + 1 :] - 850.0) < 150.0])
    assert ends - crossing > 1e-6
    mu = crossing + (ends - crossing) * np.array([-0.1, 0.1, 0.3, 0.6, 0.9])
    stops = run(cells, start, mu)
    assert stops.x[0, 0] > 1000.0 or stops.status[0, 0] == LEFT_PROFILE
    expected = [fine[mean_slope(fine) <= m][0] for m in mu[1:]]
    np.testing.assert_allclose(stops.x[0, 1:], expected, atol=0.01)


def test_fast_blocks_leave_the_ground_at_the_edge() -> None:
    stops = run_from(JUMP)
    flies = np.isfinite(stops.lift_off_x[0])
    assert flies[0]
    assert not flies[-1]
    assert np.all(np.diff(flies.astype(int)) <= 0)  # the slow ones do not
    edge = stops.lift_off_x[0, flies]
    assert np.all((edge > 400.0) & (edge < 520.0))
    assert np.all(np.diff(edge) >= 0.0)  # the slower, the later
    # Where it is lost, N is zero.
    _, places, w = small_steps(JUMP, RELEASE_M, MU[:1])
    _, slope, second = JUMP.derivatives(edge[:1])
    w_there = np.interp(edge[0], places, w[:, 0])
    assert 9.81 + second[0] / (1.0 + slope[0] ** 2) * w_there == pytest.approx(0.0, abs=0.1)
    assert np.isnan(run_from(JUMP, curvature=0.0).lift_off_x).all()


NEUTRAL = [
    {"factor": 1.0},
    {"offset": 0.0},
    {"constant": 0.0},
    {"drag": 0.0},
    {"speed_factor": np.ones(len(SPEEDS))},
    {"speed_constant": np.zeros(len(SPEEDS))},
]


@pytest.mark.parametrize("neutral", NEUTRAL, ids=lambda n: next(iter(n)))
@pytest.mark.parametrize("other", [{}, {"offset": 0.03, "factor": 0.9, "drag": 0.003}])
def test_neutral_resistance_changes_no_bit(neutral, other) -> None:
    base, same = run_from(JUMP, **other), run_from(JUMP, **(neutral | other))
    for a, b in zip(base, same, strict=True):
        np.testing.assert_array_equal(a, b)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.floats(0.05, 1.2), min_size=1, max_size=70), st.randoms())
def test_each_friction_runs_as_if_alone_and_in_any_order(mu: list[float], random) -> None:
    cells, start = JUMP_CELLS
    shuffled = list(range(len(mu)))
    random.shuffle(shuffled)
    together = run(cells, start, np.array(mu)[shuffled])
    for k in range(0, len(mu), 7):
        alone = run(cells, start, np.array([mu[shuffled[k]]]))
        for a, b in zip(together, alone, strict=True):
            np.testing.assert_array_equal(a[0, k], b[0, 0])


def test_each_start_runs_as_if_alone() -> None:
    cells, _ = JUMP_CELLS
    starts = np.array([3, 0, 11])
    together = run(cells, starts, MU)
    for s, start in enumerate(starts):
        alone = run(cells, starts[s : s + 1], MU)
        assert start < len(cells.length)
        for a, b in zip(together, alone, strict=True):
            np.testing.assert_array_equal(a[s], b[0])


JUMP_TERRAIN = terrain_of(JUMP)
JUMP_CELLS = cells_of(JUMP_TERRAIN), np.array([JUMP_TERRAIN.node(RELEASE_M)])


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.floats(-25.0, 25.0), min_size=7, max_size=7),
    st.floats(0.2, 0.8),
    st.sampled_from([0.0, 1.0]),
)
def test_more_friction_never_carries_farther(bumps, slope, curvature) -> None:
    """dw/dξ = 2(g sinθ - μN) with N ≥ 0 falls with μ at every place and speed, and so does w."""
    x = np.linspace(0.0, 1500.0, 80)
    y = 1000.0 - slope * x + sum(b * np.sin((k + 1) * x / 150.0) for k, b in enumerate(bumps))
    terrain = terrain_of(spline_profile(x, y, 1.0), 0.0)
    stops = run(cells_of(terrain, curvature=curvature), np.array([0]), MU)
    reached = np.where(stops.status[0] == LEFT_PROFILE, np.inf, stops.x[0])
    assert np.all(reached[1:] <= reached[:-1] + 1e-2)
