"""Nodes between the grid points of the tables."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.effect import LimitEffect
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.refinement import refined
from avahazard.inference.likelihood.interpolation import (
    along,
    interpolated,
    line_weights,
    packed,
    stack,
    unpacked,
)
from avahazard.inference.likelihood.nodes import Nodes, build_nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.synth.making import make_world
from tests.inference.studies import near, observations, posterior

GRID = (0.0, 0.5, 1.0, 2.0, 4.0, 7.0)


def _line(value: float, values: np.ndarray) -> tuple[float, float]:
    """Values `[n_grid]` at a value of the grid, by the cubic and by the line."""
    line = line_weights(GRID, value)
    part = values[line.first : line.first + len(line.linear)]
    return float(along(line, part)), float(line.linear @ part)


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
    assert along(line, np.array([3.0, 7.0])) == pytest.approx(4.0)
    three = np.array([1.0, 2.0, 4.0])
    for value in (1.3, 3.0):
        assert along(line_weights((1.0, 2.0, 4.0), value), three**2) == pytest.approx(value**2)


def test_between_three_points_nothing_lies_beyond_its_neighbours() -> None:
    values = np.array([0.0, 1.0, 1.05])
    for value in np.linspace(1.0, 3.0, 41):
        line = line_weights((1.0, 2.0, 3.0), value)
        found = float(along(line, values[line.first : line.first + len(line.linear)]))
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
    assert -6.85 <= along(line_weights(grid, value), values) <= -6.83


def test_a_turn_between_points_is_followed() -> None:
    grid = np.array(GRID)
    values = -((grid - 1.4) ** 2)
    assert _line(1.4, values)[0] == pytest.approx(0.0, abs=1e-9)


def _afresh(model: Posterior, u: np.ndarray) -> np.ndarray:
    """Log likelihood of each event with tables and nodes made at u itself."""
    speed = model.layout.track_scatter
    limit = model.observations.limit
    values = model.layout.effect_values(u)
    for effect in model.effects:
        if isinstance(effect, LimitEffect):
            limit = effect.limit(model.observations.columns, values[effect.key])
    nodes = build_nodes(
        model.observations,
        model.nodes.predicted_at(u),
        0.0 if speed is None else float(np.exp(u[speed])),
        limit,
        model.layout.log_scatter,
        model.nodes.panels(),
    )
    return model.terms(nodes, *model.location_and_scatter(u)).value


SHAPING = {
    "turbulent-drag": {"turbulent-drag.drag": 0.5},
    "cohesion": {"cohesion.strength": 0.6},
    "entrainment": {"entrainment.rate": 0.5},
    "forest-drag": {"forest-drag.drag": 0.4},
    "epoch-bias": {"epoch-bias.shift": 1.3},
    "leading-edge": {"leading-edge.share": 0.9},
    "observation-limit": {"observation-limit.margin": 0.2},
}


@pytest.mark.parametrize("key", SHAPING)
def test_on_grid_points_the_blend_is_exact(key: str) -> None:
    model = posterior(observations(), key)
    u = near(model, **SHAPING[key])
    for k, slot in enumerate(model.layout.slots):
        if slot.grid:
            u[k] = min(slot.grid, key=lambda g, v=u[k]: abs(g - v))  # type: ignore[misc]
    assert model.event_log_likelihood(u) == pytest.approx(_afresh(model, u), abs=1e-9)


@pytest.mark.parametrize(
    ("key", "tolerance"),
    [
        ("turbulent-drag", 0.3),
        ("entrainment", 0.2),
        ("forest-drag", 0.2),
        # A shift carries records across jumps of F, where bumps change their shape.
        ("epoch-bias", 0.8),
    ],
)
def test_about_the_mode_the_blend_is_close(key: str, tolerance: float) -> None:
    """On terrain with steps: what is sampled is what tables made on the spot would give."""
    records, _ = make_world(5, 80, 8, {key: 1.0})
    model = posterior(build_observations(records), key)
    mode = find_mode(model)
    fine = refined(model, mode)
    assert fine is not model
    mode = find_mode(fine, mode.u)
    factor = np.linalg.cholesky(mode.covariance)
    rng = np.random.default_rng(3)
    drawn, errors = [], []
    for _ in range(8):
        u = mode.u + factor @ rng.standard_normal(len(mode.u))
        u = np.clip(u, fine.layout.low, fine.layout.high)
        drawn.append(np.sum(_afresh(fine, u)))
        errors.append(np.sum(fine.event_log_likelihood(u) - _afresh(fine, u)))
    # The normal about the mode reaches where no draw of the posterior would be.
    likely = np.array(drawn) > np.sum(_afresh(fine, mode.u)) - 20.0
    assert likely.sum() >= 6
    assert np.max(np.abs(errors)[likely]) < tolerance


USED = np.array([2, 4, 3])


def _corner(seed: int, plain: bool) -> Nodes:
    """Packed nodes of three events."""
    rng = np.random.default_rng(seed)
    weight = rng.random(9)
    weight /= np.repeat(np.add.reduceat(weight, [0, 2, 6]), USED)
    three = rng.random(3)
    nothing = np.empty(0)
    return Nodes(
        place=rng.normal(-0.7, 0.2, 9),
        weight=weight,
        used=USED,
        tail_place=np.tile([-3.0, 1.0], (3, 1)),
        tail=rng.random((3, 2)),
        log_scale=-three,
        is_probability=np.full(3, plain),
        floor=three,
        seen_place=nothing,
        seen_weight=nothing,
        seen_floor=np.ones(3),
        has_limit=np.zeros(3, np.bool_),
        log_wrong=np.full(3, -np.inf),
    )


LINE = line_weights((0.0, 1.0, 2.0, 3.0), 1.6)


@pytest.mark.parametrize("plain", [False, True])
def test_equal_corners_give_themselves(plain: bool) -> None:
    one = _corner(1, plain)
    found, own = interpolated([LINE], stack([one] * 4)), unpacked(one)
    for name in ("place", "weight", "tail", "log_scale", "floor"):
        np.testing.assert_allclose(
            getattr(found, name), getattr(own, name), rtol=1e-12, atol=1e-15, err_msg=name
        )


def test_two_parameters_go_one_after_the_other() -> None:
    first, second = line_weights(GRID, 1.4), line_weights((0.0, 1.0, 3.0), 0.2)
    x, y = GRID[first.first : first.first + 4], (0.0, 1.0, 3.0)
    corners = [
        _corner(1, True)._replace(log_scale=np.array([a**3 + b**2, a * b, a])) for a in x for b in y
    ]
    found = interpolated([first, second], stack(corners))
    assert found.log_scale == pytest.approx([1.4**3 + 0.2**2, 1.4 * 0.2, 1.4])


@pytest.mark.parametrize("plain", [False, True])
def test_means_go_by_cubics_and_shapes_by_lines(plain: bool) -> None:
    corners = [_corner(k, plain) for k in range(4)]
    found = interpolated([LINE], stack(corners))
    whole = [unpacked(corner) for corner in corners]
    log_scale = np.stack([w.log_scale for w in whole])
    assert found.log_scale == pytest.approx(along(LINE, log_scale))
    for i in range(3):
        means = [0.0 if plain else w.place[i] @ w.weight[i] for w in whole]
        for k in range(USED[i]):
            parts = LINE.linear * [w.weight[i, k] for w in whole]
            away = [whole[c].place[i, k] - means[c] for c in range(4)]
            assert found.weight[i, k] == pytest.approx(np.sum(parts))
            expected = along(LINE, np.array(means)) + parts @ away / np.sum(parts)
            assert found.place[i, k] == pytest.approx(expected)


@pytest.mark.parametrize("key", ["turbulent-drag", "observation-limit"])
def test_nothing_used_is_lost_by_packing(key: str) -> None:
    model = posterior(observations(), key)
    grid = model.nodes
    nodes = build_nodes(model.observations, grid.predicted((1,)), limit=model.observations.limit)
    small = packed(nodes, in_sight=False)
    assert small.place.shape == (np.sum(nodes.used),)
    again = unpacked(small)
    for name in set(Nodes._fields) - {"place", "seen_place"}:
        np.testing.assert_array_equal(getattr(again, name), getattr(nodes, name), err_msg=name)
    # Where no weight is, places say nothing.
    for place, weight in (("place", "weight"), ("seen_place", "seen_weight")):
        counts = getattr(nodes, weight) != 0.0
        one, other = getattr(again, place), getattr(nodes, place)
        np.testing.assert_array_equal(one[counts], other[counts], err_msg=place)


def test_nothing_is_kept_of_what_is_seen_where_all_is() -> None:
    given = build_observations(make_world(5, 12, 2, {})[0])
    model = posterior(given, "turbulent-drag")
    nodes = build_nodes(given, model.nodes.predicted((1,)))
    assert not nodes.has_limit.any()
    small = packed(nodes, in_sight=True)
    assert small.seen_place.size == small.seen_weight.size == 0
    np.testing.assert_array_equal(unpacked(small).seen_weight, nodes.seen_weight)
