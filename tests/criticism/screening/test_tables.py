"""Tables made some paths at a time are those made at once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.criticism.screening import tables as module
from avahazard.criticism.screening.tables import COLUMNS, model_tables
from avahazard.effects.effect import Effect, LimitEffect, MotionEffect
from avahazard.inference.likelihood import node_charts
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.predicted import run_blocks
from avahazard.inference.model import observations as arranging
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.synth.making import make_world


@cache
def on_paths() -> Observations:
    """Events of five paths in turn, one that left, some records as places."""
    records = make_world(5, 30, 5, {})[0]
    first, second, *others = records.events
    left = replace(first, left_profile=True, runout_elevation_m=None, runout_x_m=None)
    place = replace(second, runout_elevation_m=None, runout_x_m=900.0)
    turns = sorted([left, place, *others], key=lambda event: event.event_id[::-1])
    return build_observations(replace(records, events=tuple(turns)))


def effect_of(key: str) -> Effect:
    definition, of = find_definition(key, ()), on_paths()
    return definition.build(definition.facts(of.columns, of.sites))


@pytest.mark.parametrize("near", [False, True])
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("turbulent-drag", 0.001),
        ("leading-edge", 0.4),
        ("epoch-bias", 30.0),
        ("record-error", 2.0),
        ("observation-limit", 20.0),
    ],
)
def test_tables_in_parts_are_those_of_all_at_once(
    key: str, value: float, near: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    observations, effect = on_paths(), effect_of(key)
    values = {key: np.array([value, *(p.neutral for p in effect.parameters[1:])])}
    limit = observations.limit
    if isinstance(effect, LimitEffect):
        limit = effect.limit(observations.columns, values[key])
    about = np.linspace(-1.5, -0.5, observations.n_events)
    # What moves no block has the runs of the model itself.
    runs = None if isinstance(effect, MotionEffect) else run_blocks(observations, (), {})
    told = observations, (effect,), values, 1.0, limit, 0.0, about, runs, near
    whole = model_tables(*told)
    monkeypatch.setattr(node_charts, "MANY_EVENTS", 10)
    monkeypatch.setattr(module, "EVENTS_AT_ONCE", 10)
    parts = model_tables(*told)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name), err_msg=name)
    for one, other in zip(parts.edges, whole.edges, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(parts.speeds.row, whole.speeds.row)


def test_sites_past_the_first_keep_no_terrain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arranging, "KEPT_SITES", 2)
    observations = build_observations(make_world(5, 30, 5, {})[0])
    effect = effect_of("turbulent-drag")
    run_blocks(observations, (effect,), {effect.key: np.array([0.001])})
    assert [len(site.kept) for site in observations.sites] == [1, 1, 0, 0, 0]
