"""The catalogue against its promised keys, and every effect's own description."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from avahazard.effects.catalogue import catalogue, definition, require
from avahazard.effects.effect import Effect, FrictionEffect, shapes_tables
from avahazard.records.collection import Event
from avahazard.records.errors import AvahazardError
from tests.effects.examples import columns, sites

KEYS = tuple(catalogue())

NEEDS = {
    "centrifugal": "profile",
    "turbulent-drag": "profile; speeds help",
    "speed-weakening": "profile; speeds help",
    "cohesion": "profile; speeds help",
    "entrainment": "profile, varied release",
    "force:speed": "profile; speeds help",
    "forest-drag": "land_cover",
    "force:slope": "profile; speeds help",
    "force:elevation": "profile; speeds help",
    "force:curvature": "profile; speeds help",
    "force:distance": "profile; speeds help",
    "volume-law": "volume",
    "volume-scatter": "volume",
    "snow-type": "snow_type",
    "path-section": "section",
    "release-elevation": "release_elevation_m",
    "season": "date",
    "path-effect": ">= 5 paths",
    "winter-effect": "date",
    "storm-effect": "date",
    "observation-limit": "observed_below_m, or estimated",
    "two-kinds": "30 events",
    "epoch-bias": "date",
    "leading-edge": "deposit length",
    "record-error": "20 events",
    "volume-error": "20 events with volumes that are not exact",
}
"""The keys that people and stored models rely on, and what each needs."""
EVERY = (
    *KEYS,
    "covariate:wind",
    "covariate:snow_type",
    "interaction:wind*snow_type",
    "change:all",
    "scatter:snow_type",
)
SENTENCE = re.compile(r"[.!?](?=\s+[A-Z]|$)")


def _effect(key: str) -> Effect:
    entry = definition(key)
    return entry.build(json.loads(json.dumps(entry.facts(columns(), sites()))))


def test_the_catalogue_has_the_promised_keys_in_their_order() -> None:
    assert [(key, definition(key).needs) for key in KEYS] == list(NEEDS.items())


@pytest.mark.parametrize("key", EVERY)
def test_an_entry_tells_what_it_means_in_two_sentences(key: str) -> None:
    entry = definition(key)
    assert entry.key == key
    assert len(SENTENCE.findall(entry.meaning)) == 2
    assert 80 < len(entry.meaning) < 400
    assert entry.changes is None or entry.changes.field in ("law", "scatter", "centrifugal")


@pytest.mark.parametrize("key", EVERY)
def test_parameters_have_a_prior_within_their_range(key: str) -> None:
    effect = _effect(key)
    assert effect.key == key
    assert (type(effect) is Effect) == (definition(key).changes is not None)
    assert bool(effect.parameters) == (type(effect) is not Effect)
    for p in effect.parameters:
        assert p.prior_sd > 0.0
        assert p.low <= p.neutral <= p.high
        assert p.low <= p.prior_mean <= p.high
        if shapes_tables(effect):
            tried = p.plausible(6)
            assert p.neutral not in tried
            assert 5 <= len(set(tried)) <= 6
            assert p.low - 1e-9 <= min(tried) <= max(tried) <= p.high + 1e-9
            assert (
                len(effect.parameters) > 1
                or np.isclose([p.low, p.high], [min(tried), max(tried)]).any()
            )


@pytest.mark.parametrize("key", EVERY)
def test_what_an_effect_takes_from_the_data_survives_json(key: str) -> None:
    entry = definition(key)
    facts = entry.facts(columns(), sites())
    before, after = entry.build(facts), _effect(key)
    assert before.parameters == after.parameters
    if isinstance(before, FrictionEffect) and isinstance(after, FrictionEffect):
        design = before.design(columns())
        assert design.shape == (36, len(before.parameters))
        assert np.all(np.isfinite(design))
        assert np.array_equal(design, after.design(columns()))


@pytest.mark.parametrize("key", EVERY)
def test_complete_data_lack_nothing(key: str) -> None:
    require(definition(key), columns(), sites())


LACKING = {
    "centrifugal": "no event lies on a path with a profile",
    "turbulent-drag": "no event lies on a path with a profile",
    "speed-weakening": "no event lies on a path with a profile",
    "cohesion": "no event lies on a path with a profile",
    "entrainment": "no event lies on a path with a profile",
    "forest-drag": "no event lies on a path with a profile",
    "volume-law": "no (different) volumes",
    "volume-scatter": "no (different) volumes",
    "snow-type": "no column snow_type",
    "path-section": "section has no two values with at least 5 events each",
    "release-elevation": "release elevations differ by less than 50 m",
    "season": "fewer than 20 events have a day",
    "path-effect": "there are 0 paths, fewer than 5",
    "observation-limit": "no event lies on a path with a profile",
    "epoch-bias": "fewer than 20 dated events over 20 years",
    "leading-edge": "fewer than 10 events have a deposit length",
    "covariate:wind": "no column wind",
}


@pytest.mark.parametrize("key", LACKING)
def test_what_the_data_lack_is_said(key: str) -> None:
    bare = tuple(Event(f"s{i}", fall_height_m=500.0, runout_length_m=900.0) for i in range(30))
    table = columns(bare)
    table = type(table)(
        **{name: getattr(table, name) for name in table.__slots__ if name != "release_elevation"},
        release_elevation=np.full(30, np.nan),
    )
    with pytest.raises(AvahazardError, match=re.escape(LACKING[key])) as caught:
        require(definition(key), table, ())
    assert f"'{key}'" in caught.value.message
    assert definition(key).needs in str(caught.value.hint)


def test_a_forest_is_needed() -> None:
    with pytest.raises(AvahazardError, match="land_cover `forest`"):
        require(definition("forest-drag"), columns(), sites(land_cover=None))


@pytest.mark.parametrize("key", ["friction", "covariate:", "Cohesion"])
def test_an_unknown_key_names_the_known_ones(key: str) -> None:
    with pytest.raises(AvahazardError, match="no effect") as caught:
        definition(key)
    assert all(known in str(caught.value.hint) for known in KEYS)
