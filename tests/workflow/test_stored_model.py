"""Models in and out of the database."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from avahazard.effects.effect import Definition, Effect, Parameter
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.chains import chains
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event, Speed
from avahazard.records.fingerprint import data_fingerprint
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrated import Calibrated, result_document
from avahazard.workflow.stored_model import (
    coordinates_for,
    load_stored,
    only_paths,
    posterior_for,
    records_changed,
    require_unchanged,
    save_calibrated,
    training_records,
)
from tests.workflow.twin import twin_records, twin_study
from tests.workflow.worlds import bowl

SPECIFICATION = Specification(law="power", scatter="volume", tails="student", centrifugal=False)


def _found(**changes: Any) -> Calibrated:
    """A calibration with made-up draws on the twin, with effects and facts."""
    specification, facts = with_effects(
        twin_study(), SPECIFICATION, ["path-section", "turbulent-drag"]
    )
    posterior = assemble(twin_study(), specification, facts)
    slots = tuple(s.name for s in posterior.layout.slots)
    u = np.abs(np.random.default_rng(0).normal(0.1, 0.01, (2, 50, len(slots))))
    readable = posterior.layout.readable(u)
    values = np.stack([v for v, _ in readable.values()], axis=-1)
    found = Calibrated(
        specification,
        facts,
        "marginal",
        chains(tuple(readable), tuple(unit for _, unit in readable.values()), values),
        slots,
        u,
        173,
        offsets={"scey": u[..., 0]},
        grids={"turbulent-drag.drag": (0.0, 0.1 + 0.2, 1.0)},
    )
    return replace(found, **changes)


def _store(database: str, found: Calibrated, **more: Any) -> None:
    with writing(database) as session:
        save_records(session, twin_records())
    records = only_paths(twin_records(), more.get("paths", ()))
    document = result_document(found, "m", seed=1, data_fingerprint=data_fingerprint(records))
    save_calibrated(database, found, document, **more)


def test_a_model_comes_back_whole(any_database: str) -> None:
    found = _found()
    _store(any_database, found, paths=("scey", "saugy"))
    stored, records = load_stored(any_database, "m")
    assert stored.specification == found.specification
    assert stored.facts == found.facts
    assert (stored.name, stored.parent, stored.method) == ("m", None, "marginal")
    assert stored.paths == ("scey", "saugy")
    assert stored.grids == found.grids
    np.testing.assert_array_equal(
        stored.coordinates, found.coordinates.reshape(-1, len(found.slots))
    )
    np.testing.assert_array_equal(stored.offsets["scey"], found.offsets["scey"].ravel())
    assert stored.result["parameters"].keys() == {*found.chains.names, "path:scey"}
    assert len(training_records(stored, records).events) == 34
    require_unchanged(stored, records)


def test_the_posterior_is_the_same_as_before(database: str) -> None:
    found = _found(grids={})
    _store(database, found)
    stored, records = load_stored(database, "m")
    _, posterior = posterior_for(stored, training_records(stored, records))
    before = assemble(twin_study(), found.specification, found.facts)
    u = found.coordinates[0, 0]
    assert posterior.log_density(u) == before.log_density(u)
    assert np.isfinite(before.log_density(u))
    np.testing.assert_array_equal(coordinates_for(stored, posterior), stored.coordinates)


def test_refined_grids_are_kept(database: str) -> None:
    grid = tuple(float(v) for v in np.linspace(0.05, 0.15, 5))
    _store(database, _found(grids={"turbulent-drag.drag": grid}))
    stored, records = load_stored(database, "m")
    _, posterior = posterior_for(stored, records)
    slot = next(s for s in posterior.layout.slots if s.name == "turbulent-drag.drag")
    assert (slot.grid, slot.low, slot.high) == (grid, grid[0], grid[-1])


def test_other_records_with_speeds_and_without_a_volume(database: str) -> None:
    _store(database, _found(grids={}))
    stored, records = load_stored(database, "m")
    event = Event("new", "scey", runout_elevation_m=1100.0, volume_m3=None)
    speed = Speed("new", 30.0, 3.0, x_m=500.0)
    new = Records(records.paths, records.profiles, (event,), (speed,))
    prior = build_observations(training_records(stored, records))
    observations, posterior = posterior_for(stored, new, prior)
    assert observations.volumes.centre == prior.volumes.centre
    u = coordinates_for(stored, posterior)
    assert u.shape == (100, len(stored.slots) + 1)
    assert np.unique(u[:, -1]) == [pytest.approx(np.log(3.0))]
    assert np.isfinite(posterior.log_density(u[0]))


def test_records_that_changed_since(database: str) -> None:
    _store(database, _found(), paths=("scey",))
    with writing(database) as session:
        save_records(session, bowl(events=(Event("E", "B", runout_x_m=1500.0),)))
    stored, records = load_stored(database, "m")
    assert not records_changed(stored, records)  # another path's
    with writing(database) as session:
        save_records(session, Records(events=(Event("E2", "scey", runout_elevation_m=1100.0),)))
    stored, records = load_stored(database, "m")
    assert records_changed(stored, records)
    with pytest.raises(AvahazardError, match="have changed since m was calibrated") as error:
        require_unchanged(stored, records)
    assert "avahazard calibrate" in error.value.hint


def test_a_users_effect_is_asked_for_again(database: str) -> None:
    found = _found()
    effects = (*found.specification.effects, "my-own")
    found = _found(specification=replace(found.specification, effects=effects))
    _store(database, found, effect_file="raise SystemExit")
    with pytest.raises(AvahazardError, match="'my-own' from its user's file") as error:
        load_stored(database, "m")
    assert "--effect-file" in error.value.hint
    own = Definition(
        "my-own", "", "", lambda _: Effect("my-own", (Parameter("k", "", 0.0, 0.0, 1.0),))
    )
    assert load_stored(database, "m", [own])[0].own == (own,)


def test_paths_that_are_not_there_or_have_no_events() -> None:
    with pytest.raises(AvahazardError, match="no path 'nowhere'"):
        only_paths(twin_records(), ["scey", "nowhere"])
    with pytest.raises(AvahazardError, match="no events on B"):
        only_paths(bowl(), ["B"])
    some = only_paths(twin_records(), ["saugy", "scey"])
    assert {e.path_id for e in some.events} == {p.path_id for p in some.profiles}
    assert [p.path_id for p in some.paths] == ["saugy", "scey"]
