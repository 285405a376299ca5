from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from avahazard.inference.likelihood import kept_runs
from avahazard.inference.likelihood.kept_runs import LEAST_KEPT, MOST_BYTES, within
from avahazard.inference.likelihood.node_charts import between, mixing, star
from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.predicted import BlockRuns, predict_records, run_blocks
from avahazard.inference.model.layout import arm_between
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.physics.runout_curve import MU
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from tests.inference.studies import near, observations, posterior


def test_large_tables_are_kept_in_smaller_number() -> None:
    assert within(16, 1000) == 16
    assert within(16, MOST_BYTES // 5) == 5
    assert within(16, 10 * MOST_BYTES) == LEAST_KEPT


def test_blocks_that_no_parameter_moves_are_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(observations(speeds=False))
    model.nodes.at(near(model))
    with monkeypatch.context() as patch:
        patch.setattr(kept_runs, "run_blocks", None)
        found = model.nodes.predicted_at(near(model))
    fresh = predict_records(model.observations, (), {})
    np.testing.assert_array_equal(found.record, fresh.record)


def test_blocks_that_parameters_move_are_run_for_each() -> None:
    model = posterior(observations(speeds=False), "turbulent-drag")
    weak, strong = (
        model.nodes.predicted_at(near(model, **{"turbulent-drag.drag": drag})).record
        for drag in (0.1, 2.0)
    )
    assert not np.array_equal(weak, strong, equal_nan=True)


@cache
def in_sight() -> Observations:
    """Events of which sight is not limited, some with speeds and one that left."""
    records = make_world(5, 24, 2, {}, Settings(speeds=0.4))[0]
    gone = replace(records.events[3], left_profile=True, runout_elevation_m=None, runout_x_m=None)
    events = tuple(gone if e.event_id == gone.event_id else e for e in records.events)
    return build_observations(replace(records, events=events))


@pytest.mark.parametrize(
    "effects", [("turbulent-drag",), ("cohesion", "leading-edge"), ("speed-weakening",)]
)
def test_nodes_near_the_records_are_those_of_whole_tables(effects: tuple[str, ...]) -> None:
    model = posterior(in_sight(), *effects)
    nodes, layout = model.nodes, model.layout
    for share in (0.3, 0.9):
        u = near(model)
        for k in layout.tables:
            u[k] = layout.low[k] + share * (layout.high[k] - layout.low[k])
        scatter = float(np.exp(u[-1]))
        found = nodes.exact(u)
        whole = build_nodes(
            model.observations, nodes.predicted_at(u), scatter, None, True, nodes.panels()
        )
        for name in ("weight", "tail", "log_scale", "floor"):
            np.testing.assert_allclose(
                getattr(found, name), getattr(whole, name), rtol=1e-9, atol=1e-12, err_msg=name
            )
        counts = whole.weight > 0.0
        np.testing.assert_allclose(found.place[counts], whole.place[counts], rtol=1e-9)


def test_few_frictions_are_run_near_the_records(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(in_sight(), "turbulent-drag")
    runs: list[BlockRuns] = []

    def kept(*args: Any) -> BlockRuns:
        runs.append(run_blocks(*args))
        return runs[-1]

    monkeypatch.setattr(kept_runs, "run_blocks", kept)
    model.nodes.panels()
    model.nodes.exact(near(model, **{"turbulent-drag.drag": 0.3}))
    whole, some = runs
    frictions = [np.count_nonzero(s.any(axis=1)) for s in some.speeds]
    assert np.mean(frictions) < 0.3 * np.mean(
        [np.count_nonzero(s.any(axis=1)) for s in whole.speeds]
    )
    distinct = [len(np.unique(row)) for table in some.tables for row in table.x]
    assert np.mean(distinct) < 0.3 * len(MU)


def test_a_scatter_along_tracks_asks_for_no_new_run(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(in_sight(), "turbulent-drag")
    values = {"turbulent-drag.drag": 0.3}
    one = model.nodes.exact(near(model, **values, **{"log track sigma": -3.0}))
    monkeypatch.setattr(kept_runs, "run_blocks", None)
    other = model.nodes.exact(near(model, **values, **{"log track sigma": -2.0}))
    assert not np.array_equal(one.log_scale, other.log_scale)


ARMS = ((0.3, 0.0, 0.1, 0.5, 0.8), (-1.0, -3.0, -2.0, 0.0, 1.0), (2.0, 2.5, 3.0, 3.5, 4.0))


def test_a_star_has_points_along_each_axis_and_two_for_each_pair() -> None:
    points = star(ARMS)
    assert points.shape == (1 + 3 * 4 + 3 * 2, 3)
    moved = np.sum(points != points[0], axis=1)
    assert moved.tolist() == [0] + 12 * [1] + 6 * [2]


def test_a_chart_is_exact_for_products_and_squares() -> None:
    def value(x: np.ndarray) -> np.ndarray:
        a, b, c = x.T
        return 1.0 + a**2 - 2.0 * a - b**2 / 7.0 + c**2 + 3.0 * a * b - b * c

    at = value(star(ARMS))[:, None]
    rng = np.random.default_rng(1)
    for _ in range(20):
        place = np.array([rng.uniform(min(arm), max(arm)) for arm in ARMS])
        found = between(ARMS, place, at)[0]
        # The limits of the cubics let go of a turn within a cell.
        assert found == pytest.approx(value(place[None])[0], abs=0.07)
        assert mixing(ARMS, place).sum() == pytest.approx(1.0)


def test_a_point_of_an_arm_stands_for_itself() -> None:
    points = star(ARMS)
    at = np.random.default_rng(2).normal(size=(len(points), 3))
    for k, point in enumerate(points[:13]):
        np.testing.assert_allclose(between(ARMS, point, at), at[k], atol=1e-12)
        np.testing.assert_allclose(mixing(ARMS, point), np.eye(len(points))[k], atol=1e-12)


def test_beyond_a_star_its_ends_count() -> None:
    at = np.random.default_rng(2).normal(size=(len(star(ARMS)), 3))
    inside, beyond = np.array([0.8, -3.0, 2.0]), np.array([9.0, -9.0, -9.0])
    np.testing.assert_array_equal(between(ARMS, inside, at), between(ARMS, beyond, at))
    np.testing.assert_array_equal(mixing(ARMS, inside), mixing(ARMS, beyond))


@pytest.mark.parametrize("centre", [0.0, 0.1, 0.5, 1.0])
def test_an_arm_has_its_points_on_both_sides_of_the_centre(centre: float) -> None:
    points = arm_between(centre, 0.0, 1.0, 4)
    assert points[0] == centre
    assert len(set(points)) == 5
    assert (min(points), max(points)) == (0.0, 1.0)


def test_a_chart_holds_at_the_points_of_its_star() -> None:
    model = posterior(in_sight(), "turbulent-drag", "leading-edge")
    drag = (0.3, 0.2, 0.25, 0.35, 0.4)
    model = model.on_star({"turbulent-drag.drag": drag})
    u = near(model, **{"turbulent-drag.drag": 0.3, "leading-edge.share": 1.0})
    for value in drag:
        u[model.layout.tables[0]] = value
        assert model.log_likelihood(u) == pytest.approx(model.exact_log_likelihood(u), abs=1e-8)
