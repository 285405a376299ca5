"""F(μ): its table, jumps, inverse and derivative; runs near some stops against all of them."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.block import LEFT_PROFILE, NOT_RELEASED, STOPPED, run
from avahazard.physics.cells import SPEEDS
from avahazard.physics.runout_curve import (
    EVEN,
    MARGIN,
    MU,
    MU_STEP,
    SLOW_MARGIN,
    Asked,
    NearStops,
    RunoutCurve,
    filled,
    inverse,
    near_stops,
    piece_at,
    pieces,
    steps_of,
    tabulate,
)
from avahazard.physics.smooth_profile import SmoothProfile
from tests.physics.naive import naive_broken, naive_stop
from tests.physics.paths import bowl, cells_of, ski_jump, spline_profile, terrain_of

N = len(MU)
JUMP = int(np.searchsorted(MU, 0.345))
"""The node after the jump of `curve_of`."""


def curve_of(jump_m: float = 400.0) -> RunoutCurve:
    """Left below 0.195, stops with a jump about 0.345, held above 0.645."""
    x = 2500.0 - 3000.0 * MU
    x[JUMP:] -= jump_m
    y = 1000.0 + (2500.0 - x) * 0.4
    status = np.full(N, STOPPED, dtype=np.int8)
    left, held = MU < 0.1949, MU > 0.6451
    status[left], x[left], y[left] = LEFT_PROFILE, np.nan, np.nan
    status[held], x[held], y[held] = NOT_RELEASED, 0.0, 2000.0
    return RunoutCurve(x, y, status)


def random_curves(n: int) -> RunoutCurve:
    """Curves with steps of all sizes, rests, and changes of status anywhere."""
    rng = np.random.default_rng(3)
    step = np.exp(rng.normal(1.0, 1.5, (n, N))) * (rng.random((n, N)) > 0.2)
    x = 3000.0 - np.cumsum(step, axis=1)
    status = np.where(rng.random((n, N)) < 0.1, rng.integers(1, 3, (n, N)), 0).astype(np.int8)
    x[status == LEFT_PROFILE] = np.nan
    return RunoutCurve(x, 2000.0 - 0.3 * x, status)


def test_the_grid_is_even_for_avalanches_and_covers_all_that_flows() -> None:
    np.testing.assert_allclose(np.diff(MU[EVEN]), MU_STEP)
    assert (MU[EVEN][0], MU[EVEN][-1]) == (0.02, pytest.approx(1.6))
    assert (MU[0], MU[-1]) == (pytest.approx(0.001), pytest.approx(3.0))
    width = np.diff(MU)
    growth = width[1:] / width[:-1]
    # Never near the factor that makes a jump of a cell, nor wider than an eighth of its friction.
    assert growth.min() > 0.85
    assert growth.max() < 1.2
    assert np.all(width / MU[:-1] < 0.14)
    assert (len(MU) - 1) % 4 == 0
    assert EVEN.start % 4 == 0


def test_frictions_are_counted_in_steps_of_the_grid() -> None:
    steps = np.array([0.0, 0.5, 23.25, 24.0, 300.75, 656.0, 670.5, len(MU) - 1.0])
    cell = np.minimum(steps.astype(int), len(MU) - 2)
    mu = MU[cell] + (steps - cell) * (MU[cell + 1] - MU[cell])
    np.testing.assert_allclose(steps_of(mu), steps, atol=1e-9)
    np.testing.assert_array_equal(steps_of(np.array([1e-9, -1.0, 99.0])), [0, 0, len(MU) - 1])
    rows = np.zeros((2 * len(MU), 4))
    for m, step in zip(mu, steps, strict=True):
        assert piece_at.py_func(rows, m)[1] == pytest.approx(step, abs=1e-9)
    below, above = (piece_at.py_func(rows, m) for m in (0.0, 5.0))
    assert below[0] == 0
    assert below[1] < 0.0
    assert above[0] == len(rows) - 1


def test_the_table_is_the_runs() -> None:
    cells = cells_of(terrain_of(bowl()))
    starts = np.array([0, 9, 4])
    table, stops = tabulate(cells, starts), run(cells, starts, MU)
    np.testing.assert_array_equal(table.x, stops.x)
    np.testing.assert_array_equal(table.y, stops.y)
    assert table.x.shape == (3, len(MU))
    np.testing.assert_array_equal(table.left, np.isnan(table.x))
    held = table.x == cells.x[starts][:, None]
    np.testing.assert_array_equal(table.status == NOT_RELEASED, held)
    assert table.left.any()
    assert held.any()


def test_cells_are_broken_as_the_twin_says() -> None:
    curves = random_curves(20)
    discontinuous = curves.discontinuous
    found = [
        [naive_broken(x, s, c) for c in range(N - 1)]
        for x, s in zip(curves.x, curves.status, strict=True)
    ]
    np.testing.assert_array_equal(discontinuous, found)
    stopped = curves.status == STOPPED
    inside = stopped[:, 1:] & stopped[:, :-1]
    assert 0 < np.sum(discontinuous & inside) < np.sum(inside)
    np.testing.assert_array_equal(curves.jumps, discontinuous & inside)


def test_what_is_looked_up_is_the_twins() -> None:
    curves = random_curves(8)
    mu = np.exp(np.random.default_rng(1).uniform(np.log(5e-4), np.log(4.0), (8, 300)))
    x, y, status = curves.at(mu)
    for k in range(8):
        one = [naive_stop(curves[k], m) for m in mu[k]]
        np.testing.assert_allclose(x[k], [s[0] for s in one], atol=1e-9)
        np.testing.assert_allclose(y[k], [s[1] for s in one], atol=1e-9)
        np.testing.assert_array_equal(status[k], [s[2] for s in one])
        # And so are the pieces, of which the draws of hazard are made.
        rows, of_piece = pieces(curves[k])
        for m, (stop_x, stop_y, code) in zip(mu[k], one, strict=True):
            p, t = piece_at.py_func(rows, m)
            assert of_piece[p] == code
            if code != LEFT_PROFILE:
                assert rows[p, 0] + rows[p, 1] * t == pytest.approx(stop_x, abs=1e-6)
                assert rows[p, 2] + rows[p, 3] * t == pytest.approx(stop_y, abs=1e-6)
            else:
                assert (rows[p, 0], rows[p, 2]) == (np.inf, -np.inf)


def test_status_is_that_of_the_nearer_node() -> None:
    *_, status = curve_of().at(np.array([0.1936, 0.1939, 0.6461, 0.6464]))
    assert status.tolist() == [LEFT_PROFILE, STOPPED, STOPPED, NOT_RELEASED]


def test_nothing_stops_within_a_jump() -> None:
    curve = curve_of()
    x, _, _ = curve.at(np.linspace(0.33, 0.36, 301))
    assert not np.any((x > curve.x[JUMP] + 1e-9) & (x < curve.x[JUMP - 1] - 1e-9))


def test_a_curve_that_steepens_smoothly_has_no_jump() -> None:
    x = 3000.0 * np.exp(-4.0 * (0.1 + 0.01 * np.arange(40)))
    assert not RunoutCurve(x, -x, np.zeros(40, dtype=np.int8)).discontinuous.any()


def test_coarse_runs_are_filled_straight_but_for_jumps() -> None:
    x = 2000.0 - 1000.0 * MU[::4]
    x[50:] -= 300.0
    status = np.zeros((1, len(x)), dtype=np.int8)
    status[0, :9] = LEFT_PROFILE
    fine = filled(RunoutCurve(x[None], -x[None], status))
    np.testing.assert_allclose(fine.x[:, : len(MU) : 4], x[None, : len(MU[::4])])
    np.testing.assert_allclose(fine.x[0, 36:197], 2000.0 - 1000.0 * MU[36:197])
    np.testing.assert_array_equal(fine.x[0, 196:201], x[[49, 49, 50, 50, 50]])
    np.testing.assert_array_equal(fine.left[0, 30:40], np.arange(30, 40) < 34)
    # The jump is one in the fine table too.
    assert np.flatnonzero(fine.jumps[0]).tolist() == [197]


def test_the_inverse_gives_back_the_friction() -> None:
    curve = tabulate(cells_of(terrain_of(bowl())), np.array([0]))[0]
    values = np.where(curve.left, np.inf, curve.x)
    mu = np.linspace(0.4, 0.6, 50)
    x = curve.at(mu)[0]
    found = [inverse(values, curve.discontinuous, place) for place in x]
    np.testing.assert_allclose(found, mu, atol=1e-9)
    lowest, highest = np.min(values) - 1.0, 1e6
    assert inverse(values, curve.discontinuous, lowest) == np.inf
    # Only what leaves goes so far: the edge is midway to the first that stops.
    last_left = np.flatnonzero(curve.left)[-1]
    found = inverse(values, curve.discontinuous, highest)
    assert found == pytest.approx(0.5 * (MU[last_left] + MU[last_left + 1]))
    assert inverse(-MU, curve.discontinuous, 0.0) == 0.0


def test_within_a_jump_the_inverse_is_its_middle() -> None:
    x = 2000.0 - 1000.0 * MU
    x[100:] -= 300.0
    level = np.array([x[100] + 1.0, x[99] - 1.0])
    discontinuous = RunoutCurve(x, -x, np.zeros(len(MU), dtype=np.int8)).discontinuous
    for place in level:
        assert inverse(x, discontinuous, place) == pytest.approx(MU[99] + 0.5 * MU_STEP)
    straight = [inverse(x, np.zeros_like(discontinuous), place) for place in level]
    assert np.ptp(straight) > 0.4 * MU_STEP


def test_the_derivative_is_that_of_the_runs() -> None:
    cells = cells_of(terrain_of(bowl()))
    table = tabulate(cells, np.array([0]))[0]
    dx, dy = table.derivative()
    h = 1e-4
    near = run(cells, np.array([0]), np.column_stack([MU - h, MU + h]).ravel())
    by_hand = np.diff(near.x.reshape(-1, 2), axis=1)[:, 0] / (2.0 * h)
    inside = (MU > 0.4) & (MU < 0.6)
    np.testing.assert_allclose(dx[inside], by_hand[inside], rtol=2e-3)
    by_hand = np.diff(near.y.reshape(-1, 2), axis=1)[:, 0] / (2.0 * h)
    np.testing.assert_allclose(dy[inside], by_hand[inside], rtol=5e-3)
    assert np.isnan(dx[table.left]).all()
    assert np.isnan(dy[table.status == NOT_RELEASED]).all()


def test_at_a_jump_the_derivative_is_that_of_its_own_side() -> None:
    dx, dy = curve_of().derivative()
    stops = (MU > 0.1949) & (MU < 0.6451)
    np.testing.assert_allclose(dx[stops], -3000.0)
    np.testing.assert_allclose(dy[stops], 1200.0)
    assert np.isnan(dx[~stops]).all()


def stepped() -> SmoothProfile:
    """A bowl with a bench half-way, over which F jumps."""
    x = np.linspace(0.0, 2500.0, 251)
    smooth = 2000.0 - 1070.0 * (1.0 - np.exp(-x / 900.0))
    return spline_profile(x, smooth + 25.0 * np.exp(-(((x - 1000.0) / 60.0) ** 2)), sigma=0.1)


WEAKENING = 0.5 + 0.5 / (1.0 + SPEEDS / 8.0)
GROUNDS = {
    "bowl": cells_of(terrain_of(bowl()), drag=1e-3),
    "jump": cells_of(terrain_of(ski_jump()), drag=1e-3),
    "by speed": cells_of(terrain_of(bowl(), max_cell=10.0), speed_factor=WEAKENING),
    "by speed, jump": cells_of(terrain_of(stepped(), max_cell=10.0), speed_factor=WEAKENING),
}


def setting(name: str, low: float, high: float, middle: int) -> tuple[NearStops, RunoutCurve]:
    cells = GROUNDS[name]
    starts = np.array([np.flatnonzero(cells.x == 100.0)[0]])
    asked = Asked(np.array([low]), np.array([high]), np.array([middle]))
    return near_stops(cells, starts, asked), RunoutCurve(*run(cells, starts, MU)[:3])


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_all_that_stops_there_is_run_and_its_neighbours(name: str, share: float) -> None:
    x = GROUNDS[name].x
    low = x[0] + share * (x[-1] - x[0])
    found, whole = setting(name, low, low + 60.0, 100)
    rows = slice(found.first[0], found.end[0])
    np.testing.assert_array_equal(found.curve.x[0, rows], whole.x[0, rows])
    np.testing.assert_array_equal(found.curve.y[0, rows], whole.y[0, rows])
    np.testing.assert_array_equal(found.curve.status[0, rows], whole.status[0, rows])
    beyond = np.flatnonzero(whole.left[0] | (whole.x[0] > low + 60.0))[-1]
    short = np.flatnonzero(whole.x[0] < low)[0]
    margin = SLOW_MARGIN if name.startswith("by speed") else MARGIN
    assert found.first[0] == max(beyond - margin, 0)
    assert found.end[0] == min(short + 1 + margin, len(MU))
    assert found.end[0] - found.first[0] < len(MU) // 3


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("high", [1500.0, np.inf])
def test_it_is_the_same_wherever_it_begins(name: str, high: float) -> None:
    first = setting(name, 1300.0, high, 0)[0]
    for middle in (150, 400, len(MU)):
        other = setting(name, 1300.0, high, middle)[0]
        np.testing.assert_array_equal(first.curve.x, other.curve.x)
        np.testing.assert_array_equal(first.curve.status, other.curve.status)
        assert (first.first, first.end) == (other.first, other.end)


def test_beyond_the_ends_are_repeated() -> None:
    found, whole = setting("bowl", 1300.0, 1400.0, 300)
    first, end = found.first[0], found.end[0]
    assert 0 < first < end < len(MU)
    assert np.all(found.curve.x[0, :first] == whole.x[0, first])
    assert np.all(found.curve.x[0, end:] == whole.x[0, end - 1])
    assert np.all(found.curve.status[0, end:] == whole.status[0, end - 1])


def test_what_left_is_past_every_place_unless_it_is_asked_for() -> None:
    whole = setting("bowl", 0.0, 0.0, 0)[1]
    last = int(np.flatnonzero(whole.left[0])[-1])
    end_x = GROUNDS["bowl"].x[-1]
    found = setting("bowl", end_x - 1.0, end_x, 300)[0]
    assert found.first[0] == last - MARGIN
    assert setting("bowl", end_x - 1.0, np.inf, 300)[0].first[0] == 0
