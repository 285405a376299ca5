"""Values between the points of a star: limited cubics along its arms, products of axes."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.star import Star, along, line_weights

GRID = (0.0, 0.5, 1.0, 2.0, 4.0, 7.0)


def _line(value: float, values: np.ndarray) -> tuple[float, float]:
    """Values `[n_grid]` at a value of the grid, by the cubic and by the line."""
    line = line_weights(GRID, value)
    part = values[line.first : line.first + len(line.linear)]
    return float(along(line, part[:, None])[0]), float(line.linear @ part)


@pytest.mark.parametrize("value", [0.01, 0.3, 0.9, 1.5, 3.0, 5.0, 6.99])
def test_cubics_and_lines_are_met(value: float) -> None:
    grid = np.array(GRID)
    for power in range(4):
        assert _line(value, grid**power)[0] == pytest.approx(value**power)
    for row in np.eye(6):
        assert _line(value, row)[1] == pytest.approx(np.interp(value, grid, row))


@pytest.mark.parametrize("k", range(len(GRID)))
def test_at_a_grid_point_it_counts_alone(k: int) -> None:
    values = np.random.default_rng(k).normal(size=len(GRID))
    assert _line(GRID[k], values) == (values[k], values[k])


def test_short_grids_use_all_their_points() -> None:
    line = line_weights((1.0, 2.0), 1.25)
    assert (line.first, line.linear.tolist()) == (0, [0.75, 0.25])
    assert along(line, np.array([[3.0], [7.0]])) == pytest.approx(4.0)
    three = np.array([1.0, 2.0, 4.0])
    for value in (1.3, 3.0):
        line = line_weights((1.0, 2.0, 4.0), value)
        assert along(line, three[:, None] ** 2) == pytest.approx(value**2)


def test_between_three_points_nothing_lies_beyond_its_neighbours() -> None:
    values = np.array([0.0, 1.0, 1.05])
    for value in np.linspace(1.0, 3.0, 41):
        line = line_weights((1.0, 2.0, 3.0), value)
        found = along(line, values[line.first : line.first + len(line.linear), None])[0]
        low, high = (0.0, 1.0) if value <= 2.0 else (1.0, 1.05)
        assert low <= found <= high


@pytest.mark.parametrize("k", [0, 5])
@pytest.mark.parametrize("value", [0.3, 0.9, 1.5, 3.0, 5.0])
def test_a_point_far_off_lifts_nothing_between_others(k: int, value: float) -> None:
    """Where no friction reaches a record the log mass falls by hundreds."""
    grid = np.array(GRID)
    values = -8.0 + 0.1 * grid + 0.02 * grid**2
    smooth, _ = _line(value, values)
    values[k] -= 400.0
    found, _ = _line(value, values)
    if k in (np.searchsorted(grid, value), np.searchsorted(grid, value) - 1):
        assert found <= np.max(values)
    else:
        assert found == pytest.approx(smooth, abs=0.2)


@pytest.mark.parametrize("value", [2.1, 3.0, 3.9])
def test_after_a_cliff_the_values_do_not_rise_above_those_that_follow(value: float) -> None:
    """Log masses of a record that slow blocks do not reach, at the end of a grid."""
    grid, values = (0.5, 1.0, 2.0, 4.0), np.array([-12.4, -12.38, -6.85, -6.83])
    assert -6.85 <= along(line_weights(grid, value), values[:, None])[0] <= -6.83


def test_a_turn_between_points_is_followed() -> None:
    grid = np.array(GRID)
    values = -((grid - 1.4) ** 2)
    assert _line(1.4, values)[0] == pytest.approx(0.0, abs=1e-9)


ARMS = ((0.3, 0.0, 0.1, 0.5, 0.8), (-1.0, -3.0, -2.0, 0.0, 1.0), (2.0, 2.5, 3.0, 3.5, 4.0))


def test_a_star_has_points_along_each_axis_and_two_for_each_pair() -> None:
    points = Star(ARMS).points
    assert points.shape == (1 + 3 * 4 + 3 * 2, 3)
    moved = np.sum(points != points[0], axis=1)
    assert moved.tolist() == [0] + 12 * [1] + 6 * [2]


def test_a_chart_is_exact_for_products_and_squares() -> None:
    def value(x: np.ndarray) -> np.ndarray:
        a, b, c = x.T
        return 1.0 + a**2 - 2.0 * a - b**2 / 7.0 + c**2 + 3.0 * a * b - b * c

    star = Star(ARMS)
    at = value(star.points)[:, None]
    rng = np.random.default_rng(1)
    for _ in range(20):
        place = np.array([rng.uniform(min(arm), max(arm)) for arm in ARMS])
        found = star.between(star.place(place), at)[0]
        # The limits of the cubics let go of a turn within a cell.
        assert found == pytest.approx(value(place[None])[0], abs=0.07)
        assert star.mixing(star.place(place)).sum() == pytest.approx(1.0)


def test_a_point_of_an_arm_stands_for_itself() -> None:
    star = Star(ARMS)
    at = np.random.default_rng(2).normal(size=(len(star.points), 3))
    for k, point in enumerate(star.points[:13]):
        place = star.place(point)
        np.testing.assert_allclose(star.between(place, at), at[k], atol=1e-12)
        np.testing.assert_allclose(star.mixing(place), np.eye(len(star.points))[k], atol=1e-12)


def test_points_beside_the_arms_mend_what_these_say() -> None:
    """Values along a ridge that no arm follows; the twin solves for each place anew."""
    arms, rng = [(2.0, 0.0, 1.0, 3.0, 4.0), (5.0, 2.0, 3.5, 7.0, 9.0)], np.random.default_rng(4)

    def value(x: np.ndarray) -> np.ndarray:
        return -np.abs(x[..., 0] * x[..., 1] - 9.0)[..., None]

    beside = np.column_stack([rng.uniform(0.0, 4.0, 30), rng.uniform(2.0, 9.0, 30)])
    plain, star = Star(arms), Star(arms, beside)
    own = len(plain.points)
    values = star.relative(value(star.points))
    scale = np.array([2.0, 3.5])

    def alike(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        apart = np.linalg.norm((a[:, None] - b) / scale, axis=-1)
        return np.asarray(np.exp(-apart / 0.5))

    off = np.zeros(len(star.points))
    for k, at in enumerate(beside, start=own):
        off[k] = (value(at) - plain.between(plain.place(at), value(plain.points)))[0]
    errors = []
    for at in np.column_stack([rng.uniform(0.0, 4.0, 50), rng.uniform(2.0, 9.0, 50)]):
        found = star.between(star.place(at), values)
        by_arms = plain.between(plain.place(at), value(plain.points))
        kriged = alike(at[None], star.points) @ np.linalg.solve(
            alike(star.points, star.points), off
        )
        assert found == pytest.approx(by_arms + kriged, abs=1e-6)
        assert star.mixing(star.place(at)).sum() == pytest.approx(1.0)
        errors.append((float((found - value(at))[0]), float((by_arms - value(at))[0])))
    kept, before = np.sqrt(np.mean(np.square(errors), axis=0))
    assert kept < 0.6 * before
    for at in (*plain.points[:9], *beside):
        assert star.between(star.place(at), values) == pytest.approx(value(at), abs=1e-6)


def test_beyond_a_star_its_ends_count() -> None:
    star = Star(ARMS)
    at = np.random.default_rng(2).normal(size=(len(star.points), 3))
    inside, beyond = star.place([0.8, -3.0, 2.0]), star.place([9.0, -9.0, -9.0])
    np.testing.assert_array_equal(star.between(inside, at), star.between(beyond, at))
    np.testing.assert_array_equal(star.mixing(inside), star.mixing(beyond))
