"""Nodes of records made part by part are those made at once, and their tables do not add up."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.inference.likelihood import kept_runs, record_parts
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import (
    Observations,
    build_observations,
    part_of,
    whole_paths,
)
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.synth.making import make_world
from tests.inference.studies import near, posterior

X = np.linspace(0.0, 1900.0, 96)


@cache
def mixed() -> Observations:
    """Events of three paths in turn; one that left, one so vague that it has panels, one line."""
    records = make_world(5, 24, 3, {})[0]
    first, second, *others = records.events
    left = replace(first, left_profile=True, runout_elevation_m=None, runout_x_m=None)
    vague = replace(second, runout_sigma_m=150.0)
    line = Event("line", fall_height_m=500.0, runout_length_m=1200.0)
    turns = sorted([left, vague, *others], key=lambda event: event.event_id[::-1])
    return build_observations(replace(records, events=(line, *turns)))


def seldom_seen() -> Observations:
    """The same, with a limit of sight."""
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
    monkeypatch.setattr(record_parts, "MANY_EVENTS", 4)
    monkeypatch.setattr(record_parts, "EVENTS_AT_ONCE", 4)
    parts = posterior(sight(), *effects)
    assert parts.nodes._parts is not None
    assert len(parts.nodes._parts._events) > 2
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
    monkeypatch.setattr(record_parts, "MANY_EVENTS", 40)
    monkeypatch.setattr(record_parts, "EVENTS_AT_ONCE", 40)
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
    monkeypatch.setattr(record_parts, "MANY_EVENTS", 4)
    monkeypatch.setattr(record_parts, "EVENTS_AT_ONCE", 4)
    model = posterior(mixed(), effect)
    grid = model.nodes
    grid.exact(near(model))
    with monkeypatch.context() as patch:
        patch.setattr(kept_runs, "run_blocks", None)
        grid.exact(near(model, **{grid.layout.slots[grid.layout.tables[0]].name: 0.4}))
    grid.forget_runs()
    assert grid._parts is not None
    assert not any(runs._runs for runs in grid._parts._runs)
