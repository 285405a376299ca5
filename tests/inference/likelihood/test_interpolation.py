"""Nodes between the grid points of the tables."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.refinement import refined
from avahazard.inference.likelihood.interpolation import _mix, line_weights, packed, unpacked
from avahazard.inference.likelihood.nodes import Nodes, build_nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.synth.making import make_world
from tests.inference.studies import near, observations, posterior

GRID = (0.0, 0.5, 1.0, 2.0, 4.0, 7.0)


def _weights(value: float) -> tuple[np.ndarray, np.ndarray]:
    """Cubic and linear weights over the whole grid."""
    line = line_weights(GRID, value)
    cubic, linear = np.zeros(len(GRID)), np.zeros(len(GRID))
    place = slice(line.first, line.first + len(line.cubic))
    cubic[place], linear[place] = line.cubic, line.linear
    return cubic, linear


@pytest.mark.parametrize("value", [0.01, 0.3, 0.9, 1.5, 3.0, 5.0, 6.99])
def test_weights_are_exact_for_cubics_and_for_lines(value: float) -> None:
    grid = np.array(GRID)
    cubic, linear = _weights(value)
    for power in range(4):
        assert cubic @ grid**power == pytest.approx(value**power)
    assert linear @ grid == pytest.approx(value)
    assert linear.sum() == pytest.approx(1.0)
    assert np.all(linear >= 0.0)
    assert linear == pytest.approx([np.interp(value, grid, row) for row in np.eye(6)])


@pytest.mark.parametrize("k", range(len(GRID)))
def test_at_a_grid_point_it_counts_alone(k: int) -> None:
    for weights in _weights(GRID[k]):
        assert weights.tolist() == [float(j == k) for j in range(6)]


def test_short_grids_use_all_their_points() -> None:
    line = line_weights((1.0, 2.0), 1.25)
    assert (line.first, line.cubic, line.linear) == (0, (0.75, 0.25), (0.75, 0.25))


def _afresh(model: Posterior, u: np.ndarray) -> np.ndarray:
    """Log likelihood of each event with tables and nodes made at u itself."""
    speed = model.layout.track_scatter
    limit = model.observations.limit
    values = model.layout.effect_values(u)
    for effect in model.effects:
        if effect.limit is not None:
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
    errors = []
    for _ in range(8):
        u = mode.u + factor @ rng.standard_normal(len(mode.u))
        u = np.clip(u, fine.layout.low, fine.layout.high)
        errors.append(np.sum(fine.event_log_likelihood(u) - _afresh(fine, u)))
    assert np.max(np.abs(errors)) < tolerance


USED = np.array([2, 4, 3])


@pytest.mark.parametrize("plain", [False, True])
def test_equal_corners_give_themselves(plain: bool) -> None:
    rng = np.random.default_rng(1)
    place, weight = rng.normal(-0.7, 0.2, 9), rng.random(9)
    is_used = np.arange(4) < USED[:, None]
    weight /= np.repeat(np.add.reduceat(weight, [0, 2, 6]), USED)
    cubic, linear = np.array([-0.1, 0.6, 0.5]), np.array([0.0, 0.4, 0.6])
    corners = (np.tile(place, (3, 1)), np.tile(weight, (3, 1)))
    for found, one in zip(
        _mix(cubic, linear, *corners, np.full(3, plain), USED), (place, weight), strict=True
    ):
        np.testing.assert_allclose(found[is_used], one, rtol=1e-12)
        assert not found[~is_used].any()


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
