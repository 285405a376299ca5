"""A look over all records, piece by piece, against the records as a whole."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from avahazard.hazard.frequency import known_volumes
from avahazard.hazard.future_events import MAX_CLASSES
from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.records.path import Path
from avahazard.store import records as store_records
from avahazard.store.records import save_records
from avahazard.store.session import reading, writing
from avahazard.synth.making import make_world
from avahazard.workflow.stored.survey import any_events, fingerprint_of, survey


@pytest.fixture(scope="module")
def world() -> Records:
    """Seven paths with events, two without any, one of them without a profile; and a slide."""
    made, _ = make_world(2, 90, 8)
    last = made.paths[-1].path_id
    slide = Event("slide", fall_height_m=1.0, runout_length_m=2.0)
    return replace(
        made,
        paths=(*made.paths, Path("bare", covariates={"release_area_m2": 50.0})),
        events=(slide, *(e for e in made.events if e.path_id != last)),
        speeds=(Speed("slide", 3.0, 1.0, x_m=0.5), Speed(made.events[0].event_id, 9.0, 1.0, 9.0)),
    )


@pytest.fixture
def filled(any_database: str, world: Records, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(store_records, "PATHS_AT_ONCE", 3)
    with writing(any_database) as session:
        save_records(session, world)
    return any_database


def test_it_tells_what_the_whole_records_do(filled: str, world: Records) -> None:
    with reading(filled) as session:
        found = survey(session)
        some = ["P03", "P01", "P03"]
        of_some = fingerprint_of(session, some)
    assert found.fingerprint == data_fingerprint(world)
    assert of_some == data_fingerprint(only_paths(world, some))
    assert list(found.digests) == [path.path_id for path in world.paths]
    assert len(set(found.digests.values())) == len(world.paths)
    assert found.with_profile == {profile.path_id for profile in world.profiles}
    whole = known_volumes(world)
    assert found.volumes.areas == whole.areas == {"bare": 50.0}
    assert found.volumes.refused.keys() == whole.refused.keys() >= {"bare"}
    for one, other in zip(found.volumes.records, whole.records, strict=True):
        for field in fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


def test_events_that_stand_for_others_are_spread_evenly(filled: str, world: Records) -> None:
    with reading(filled) as session:
        found = any_events(session)
    there = [event for event in world.events if event.path_id is not None]
    assert len(found) == MAX_CLASSES < len(there)
    assert (found[0], found[-1]) == (there[0], there[-1])
    steps = np.diff([there.index(event) for event in found])
    assert steps.max() - steps.min() <= 1


def test_nothing_stands_for_others_where_there_is_nothing(any_database: str) -> None:
    with reading(any_database) as session:
        assert any_events(session) == ()
        assert survey(session).fingerprint == data_fingerprint(Records())
