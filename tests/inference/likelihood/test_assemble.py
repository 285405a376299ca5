"""Models put together from keys."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.assemble import (
    assemble,
    build_effects,
    find_definition,
    with_effects,
)
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Records
from avahazard.records.errors import AvahazardError
from tests.inference.studies import observations, one_path


def test_effects_are_added_in_turn_with_what_they_take_from_the_data() -> None:
    specification, facts = with_effects(
        observations(), Specification(), ["snow-type", "path-effect"]
    )
    assert specification.effects == ("snow-type", "path-effect")
    prior_sd = facts["snow-type"]["prior_sd"]
    assert prior_sd > 0.2  # by how much these records spread
    assert facts == {
        "snow-type": {"reference": "dry", "levels": ["mixed", "wet"], "prior_sd": prior_sd},
        "path-effect": {},
    }
    effects = build_effects(specification, facts)
    assert [e.key for e in effects] == ["snow-type", "path-effect"]


def test_effects_that_are_settings_change_the_specification() -> None:
    bare = Specification(centrifugal=False)
    specification, facts = with_effects(observations(), bare, ["volume-scatter", "centrifugal"])
    assert specification.centrifugal
    assert specification.scatter == "volume"
    assert specification.effects == ("volume-scatter",)
    assert facts == {}
    assert build_effects(specification, facts) == ()
    middle, high = np.exp(np.quantile(observations().volumes.mean, [0.5, 0.99]))
    assert middle < specification.reference_volume_m3 < high


def test_another_law_is_the_most_likely_of_the_others() -> None:
    given = build_observations(one_path(60, seed=5))
    specification, _ = with_effects(given, Specification(law="power"), ["volume-law"])
    modes = {
        law: find_mode(assemble(given, Specification(law=law), {})).log_density  # type: ignore[arg-type]
        for law in ("exponential", "rational")
    }
    assert specification.law == max(modes, key=lambda law: modes[law])
    assert specification.effects == ("volume-law",)


def test_an_effect_cannot_be_added_twice() -> None:
    specification, _ = with_effects(observations(), Specification(), ["season"])
    with pytest.raises(AvahazardError, match="already has the effect 'season'"):
        with_effects(observations(), specification, ["season"])


def test_an_effect_that_the_data_cannot_tell_is_refused() -> None:
    given = build_observations(one_path(20, seed=1))
    with pytest.raises(AvahazardError, match="'path-effect' cannot be estimated"):
        with_effects(given, Specification(), ["path-effect"])


def test_the_users_own_effect_goes_through_the_same_door() -> None:
    selected = replace(definition("release-elevation"), key="my-effect")
    assert find_definition("my-effect", [selected]) is selected
    specification, facts = with_effects(observations(), Specification(), ["my-effect"], [selected])
    model = assemble(observations(), specification, facts, [selected])
    assert [e.key for e in model.effects] == ["release-elevation"]
    with pytest.raises(AvahazardError, match="no effect 'my-effect'"):
        find_definition("my-effect")


def test_a_law_of_volume_needs_a_volume() -> None:
    bare = tuple(Event(f"s{i}", fall_height_m=500.0, runout_length_m=900.0 + i) for i in range(9))
    given = build_observations(Records(events=bare))
    with pytest.raises(AvahazardError, match="No event has a volume") as caught:
        assemble(given, Specification(), {})
    assert "--law constant" in caught.value.hint
    assert np.isfinite(find_mode(assemble(given, Specification(law="constant"), {})).log_density)
