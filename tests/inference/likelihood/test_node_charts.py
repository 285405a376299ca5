"""Nodes from charts and exact ones; those made part by part are those made at once."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from avahazard.inference.likelihood import node_charts, predicted
from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import BlockRuns, predict_records, run_blocks
from avahazard.inference.model.layout import Arms, arm_between
from avahazard.inference.model.observations import (
    Observations,
    build_observations,
    part_of,
    whole_paths,
)
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import every_stop
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.inference.studies import near, observations, posterior


def test_blocks_that_no_parameter_moves_are_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(observations(speeds=False))
    model.nodes.at(near(model))
    with monkeypatch.context() as patch:
        patch.setattr(predicted, "run_blocks", None)
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


def test_beyond_its_range_a_parameter_is_at_its_end() -> None:
    model = posterior(observations(speeds=False), "turbulent-drag")
    k = model.layout.places["turbulent-drag"].start
    at_end, beyond = near(model), near(model)
    at_end[k], beyond[k] = model.layout.slots[k].low, model.layout.slots[k].low - 0.5
    for got, expected in zip(model.nodes.exact(beyond), model.nodes.exact(at_end), strict=True):
        np.testing.assert_array_equal(got, expected)


@cache
def in_sight() -> Observations:
    """Events without a detection limit, some with speeds and one beyond the profile."""
    records = make_dataset(5, 24, 2, {}, Settings(speeds=0.4))[0]
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
        found, values = nodes.exact(u), layout.effect_values(u)
        asked = [every_stop(len(site.release_x)) for site in model.observations.sites]
        runs = run_blocks(model.observations, model.effects, values, asked=asked)
        tables = predict_records(model.observations, model.effects, values, runs=runs)
        whole = build_nodes(model.observations, tables, scatter, None, True, nodes.panels())
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

    monkeypatch.setattr(predicted, "run_blocks", kept)
    model.nodes.panels()
    model.nodes.exact(near(model, **{"turbulent-drag.drag": 0.3}))
    whole, some = runs
    few, all_of_them = (
        np.mean([np.count_nonzero(block.speed.any(axis=1)) for block in found.speeds])
        for found in (some, whole)
    )
    assert few < 0.3 * all_of_them
    distinct = [len(np.unique(row)) for table in some.tables for row in table.x]
    assert np.mean(distinct) < 0.3 * len(MU)


def test_a_scatter_along_tracks_asks_for_no_new_run(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(in_sight(), "turbulent-drag")
    values = {"turbulent-drag.drag": 0.3}
    one = model.nodes.exact(near(model, **values, **{"log track sigma": -3.0}))
    monkeypatch.setattr(predicted, "run_blocks", None)
    other = model.nodes.exact(near(model, **values, **{"log track sigma": -2.0}))
    assert not np.array_equal(one.log_scale, other.log_scale)


@pytest.mark.parametrize("centre", [0.0, 0.1, 0.5, 1.0])
def test_an_arm_has_its_points_on_both_sides_of_the_centre(centre: float) -> None:
    points = arm_between(centre, 0.0, 1.0, 4)
    assert points[0] == centre
    assert len(set(points)) == 5
    assert (min(points), max(points)) == (0.0, 1.0)


def test_a_chart_holds_at_the_points_of_its_star() -> None:
    model = posterior(in_sight(), "turbulent-drag", "leading-edge")
    drag = (0.3, 0.2, 0.25, 0.35, 0.4)
    model = model.on_star(Arms({"turbulent-drag.drag": drag}))
    u = near(model, **{"turbulent-drag.drag": 0.3, "leading-edge.share": 1.0})
    for value in drag:
        u[model.layout.tables[0]] = value
        assert model.log_likelihood(u) == pytest.approx(model.exact_log_likelihood(u), abs=1e-8)


X = np.linspace(0.0, 1900.0, 96)


@cache
def mixed() -> Observations:
    """Events of three paths in turn; one beyond the profile, one with panels, one line."""
    records = make_dataset(5, 24, 3, {})[0]
    first, second, *others = records.events
    left = replace(first, left_profile=True, runout_elevation_m=None, runout_x_m=None)
    vague = replace(second, runout_sigma_m=150.0)
    line = Event("line", fall_height_m=500.0, runout_length_m=1200.0)
    turns = sorted([left, vague, *others], key=lambda event: event.event_id[::-1])
    return build_observations(replace(records, events=(line, *turns)))


def seldom_seen() -> Observations:
    """The same, with a detection limit."""
    elevation = np.nanmedian(mixed().observed)
    return replace(mixed(), limit=np.where(np.isnan(mixed().limit), elevation, mixed().limit))


@pytest.mark.parametrize(
    "effects",
    [(), ("turbulent-drag",), ("record-error",), ("leading-edge", "epoch-bias"), ("entrainment",)],
)
@pytest.mark.parametrize("sight", [mixed, seldom_seen])
def test_nodes_in_parts_are_those_of_all_at_once(
    effects: tuple[str, ...], sight, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = posterior(sight(), *effects)
    monkeypatch.setattr(node_charts, "MANY_EVENTS", 4)
    monkeypatch.setattr(node_charts, "EVENTS_AT_ONCE", 4)
    parts = posterior(sight(), *effects)
    assert len(parts.nodes._parts) > 2
    u = near(whole)
    np.testing.assert_array_equal(parts.nodes.panels(), whole.nodes.panels())
    assert parts.nodes.panels().max() > 1
    for one, other in (
        (parts.nodes.at(u), whole.nodes.at(u)),
        (parts.nodes.exact(u), whole.nodes.exact(u)),
    ):
        # Weights alone tell which places count.
        for name, found, wanted in zip(one._fields, one, other, strict=True):
            if name.endswith("place") and name != "tail_place":
                counts = getattr(other, name.replace("place", "weight")) != 0.0
                np.testing.assert_array_equal(found[counts], wanted[counts], err_msg=name)
            else:
                np.testing.assert_array_equal(found, wanted, err_msg=name)
    assert parts.log_density(u) == whole.log_density(u)


def test_a_part_is_what_its_records_are_by_themselves() -> None:
    observations = mixed()
    events = whole_paths(observations, 4)[-1]
    part = part_of(observations, events)
    names = set(part.columns.paths)
    assert names < set(observations.columns.paths)
    assert [site.path.path_id for site in part.sites] == list(part.columns.paths)
    for i, k in enumerate(events):
        assert part.columns.event_id[i] == observations.columns.event_id[k]
        whose = observations.columns.paths[observations.columns.path_index[k]]
        assert part.columns.paths[part.columns.path_index[i]] == whose
    for name in ("kind", "observed", "sigma", "release", "limit"):
        np.testing.assert_array_equal(getattr(part, name), getattr(observations, name)[events])
    for name in part.columns.numbers:
        np.testing.assert_array_equal(
            part.columns.numbers[name], observations.columns.numbers[name][events]
        )


def test_parts_are_whole_paths_and_all_events() -> None:
    path = mixed().columns.path_index
    parts = whole_paths(mixed(), 4)
    assert sorted(np.concatenate(parts).tolist()) == list(range(len(path)))
    of = [set(path[part].tolist()) for part in parts]
    assert sum(map(len, of)) == len(set(path.tolist()))


def test_tables_of_more_paths_take_no_more_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_charts, "MANY_EVENTS", 40)
    monkeypatch.setattr(node_charts, "EVENTS_AT_ONCE", 40)
    few, many = (_peak_of_nodes(n) for n in (41, 164))
    assert many < 2.0 * few


def _peak_of_nodes(n: int) -> int:
    """The most memory (bytes) that is held while nodes of one event on each of n paths are made."""
    names = [f"P{k}" for k in range(n)]
    observations = build_observations(
        Records(
            tuple(Path(name) for name in names),
            tuple(Profile(m, X, 1e3 + k - 0.8 * X + 2e-4 * X**2) for k, m in enumerate(names)),
            tuple(Event(name, name, runout_x_m=1200.0) for name in names),
        )
    )
    nodes = Posterior(observations, Specification(law="constant"), ()).nodes
    tracemalloc.start()
    nodes.at(np.empty(0))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


@pytest.mark.parametrize("effect", ["leading-edge", "record-error"])
def test_runs_that_serve_other_values_are_made_once(
    effect: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(node_charts, "MANY_EVENTS", 4)
    monkeypatch.setattr(node_charts, "EVENTS_AT_ONCE", 4)
    model = posterior(mixed(), effect)
    grid = model.nodes
    grid.exact(near(model))
    with monkeypatch.context() as patch:
        patch.setattr(predicted, "run_blocks", None)
        grid.exact(near(model, **{grid.layout.slots[grid.layout.tables[0]].name: 0.4}))
    grid.forget_runs()
    assert not any(runs._runs for _, runs in grid._parts)
