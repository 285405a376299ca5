"""Models in and out of the database."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import delete, select

from avahazard.effects.effect import Definition, Effect, Parameter
from avahazard.hazard.path_hazard import path_hazard
from avahazard.inference.fitting.star import REACH
from avahazard.inference.likelihood.assemble import assemble, build_effects, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Arms
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.calibration import calibrate_paper
from avahazard.inference.prediction.extrapolation import extrapolation
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.inference.samplers.chains import chains
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event, Speed
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import of_path, only_paths
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.store.tables import ModelTable, ProfilePointTable
from avahazard.workflow.stored.calibration import calibration_result
from avahazard.workflow.stored.model import (
    load_for_paths,
    load_stored,
    on_events,
    require_unchanged,
    save_calibrated,
)
from tests.workflow.twin import twin_records, twin_study
from tests.workflow.worlds import bowl

SPECIFICATION = Specification(law="power", scatter="volume", tails="student", centrifugal=False)
ARM = (0.1, 0.05, 0.2, 0.1 + 0.2)
ARMS = {"turbulent-drag.drag": ARM}


def _found(arms: Arms | None = None, *own: Definition) -> FittedModel:
    """A calibration with made-up draws on the twin, with effects and facts."""
    specification, facts = with_effects(
        twin_study(),
        SPECIFICATION,
        ["path-section", "turbulent-drag", "path-effect", *(entry.key for entry in own)],
        own,
    )
    posterior = Posterior(
        twin_study(), specification, build_effects(specification, facts, own), arms
    )
    u = np.random.default_rng(0).normal(0.1, 0.01, (2, 50, len(posterior.layout.slots)))
    u = np.clip(u, posterior.layout.low, posterior.layout.high)
    readable = posterior.layout.readable(u)
    values = np.stack([v for v, _ in readable.values()], axis=-1)
    return replace(
        fitted_model(posterior, u.reshape(100, -1), {"scey": u[..., 0].ravel()}),
        facts=facts,
        sampled=chains(tuple(readable), tuple(unit for _, unit in readable.values()), values),
    )


def _store(database: str, found: FittedModel, **more: Any) -> None:
    with writing(database) as session:
        save_records(session, twin_records())
    records = only_paths(twin_records(), more.get("paths", ()))
    result = calibration_result(found, "m", records, seed=1)
    with writing(database) as session:
        save_calibrated(session, found, result, **more)


def test_a_model_comes_back_whole(any_database: str) -> None:
    found = _found(ARMS)
    _store(any_database, found, paths=("scey", "saugy"))
    model, all_records = load_stored(any_database, "m")
    assert model.specification == found.specification
    assert model.facts == found.facts
    assert (model.name, model.calibration.parent, model.method) == ("m", None, "marginal")
    assert model.paths == ("scey", "saugy")
    assert model.posterior.layout.slots == found.posterior.layout.slots
    np.testing.assert_array_equal(model.draws, found.draws)
    assert model.offsets.keys() == {"scey"}
    np.testing.assert_array_equal(model.offsets["scey"], found.offsets["scey"])
    assert model.calibration.parameters.keys() == {*found.chains.names, "path:scey"}
    assert len(all_records.events) == 173
    assert model.observations.n_events == len(model.columns) == 34
    require_unchanged(model)


def test_the_posterior_is_the_same_as_before(database: str) -> None:
    found = _found()
    _store(database, found)
    model = load_stored(database, "m")[0]
    before = assemble(twin_study(), found.specification, found.facts)
    u = found.draws[0]
    assert model.posterior.log_density(u) == before.log_density(u)
    assert np.isfinite(before.log_density(u))


def test_the_star_is_kept(database: str) -> None:
    _store(database, _found(ARMS))
    layout = load_stored(database, "m")[0].posterior.layout
    (slot,) = (s for s in layout.slots if s.name in ARMS)
    assert (slot.arm, slot.low, slot.high) == (ARM, min(ARM), max(ARM))


@pytest.mark.parametrize("grids", [{}, {"turbulent-drag.drag": [0.0, 0.05, 0.1, 0.2, 0.4]}])
def test_a_model_of_a_version_with_grids_stands_on_a_star_about_its_draws(
    database: str, grids: dict[str, list[float]]
) -> None:
    found = _found()
    _store(database, found)
    with writing(database) as session:
        row = session.scalars(select(ModelTable)).one()
        old = {k: v for k, v in row.specification.items() if k != "arms"}
        row.specification = {**old, "grids": grids}
    model = load_stored(database, "m")[0]
    np.testing.assert_array_equal(model.draws, found.draws)
    (k,) = model.layout.tables
    slot, drawn = model.layout.slots[k], found.draws[:, k]
    assert slot.arm[0] == np.median(drawn)
    ends = np.median(drawn) + REACH * np.std(drawn) * np.array([-1.0, 1.0])
    assert (slot.low, slot.high) == pytest.approx(ends)
    assert len(slot.arm) == 9
    for u in found.draws[[0, 50]]:
        exact = model.posterior.exact_log_likelihood(u)
        assert model.posterior.log_likelihood(u) == pytest.approx(exact, abs=0.3)


def test_the_draws_of_a_papers_method_come_back_on_exact_volumes(database: str) -> None:
    found = calibrate_paper(
        twin_study("scey"), Specification(), "gibbs", n_chains=2, n_draws=60, seed=1
    )
    _store(database, found, paths=("scey",))
    stored, everything = load_stored(database, "m")
    assert stored.method == "gibbs"
    np.testing.assert_array_equal(stored.draws, found.draws)
    assert np.all(stored.observations.volumes.sd == 0.0)
    new = on_events(
        stored, everything, [Event("new", "scey", runout_elevation_m=1100.0, volume_m3=2e4)]
    )
    assert new.method == "gibbs"
    assert np.all(new.observations.volumes.sd == 0.0)


def test_other_events_are_read_in_the_light_of_those_of_the_calibration(database: str) -> None:
    _store(database, _found(ARMS))
    stored, everything = load_stored(database, "m")
    new = on_events(
        stored, everything, [Event("new", "scey", runout_elevation_m=1100.0, volume_m3=None)]
    )
    observations, prior = new.observations, stored.observations
    assert observations.columns.event_id == ("new",)
    assert observations.volumes.population.centre == prior.volumes.population.centre
    np.testing.assert_array_equal(new.draws, stored.draws)
    assert np.isfinite(new.posterior.log_density(new.draws[0]))


def test_speeds_that_came_since_the_calibration(database: str) -> None:
    _store(database, _found())
    event = twin_records().events[0].event_id
    with writing(database) as session:
        save_records(session, Records(speeds=(Speed(event, 30.0, 3.0, x_m=500.0),)))
    stored, _ = load_stored(database, "m")
    assert stored.records_changed
    assert stored.draws.shape == (100, len(_found().posterior.layout.slots) + 1)
    assert np.unique(stored.draws[:, -1]) == [pytest.approx(np.log(0.075))]


def test_records_that_changed_since(database: str) -> None:
    _store(database, _found(), paths=("scey",))
    with writing(database) as session:
        save_records(session, bowl(events=(Event("E", "B", runout_x_m=1500.0),)))
    assert not load_stored(database, "m")[0].records_changed  # another path's
    with writing(database) as session:
        save_records(session, Records(events=(Event("E2", "scey", runout_elevation_m=1100.0),)))
    stored, _ = load_stored(database, "m")
    assert stored.records_changed
    with pytest.raises(AvahazardError, match="changed") as error:
        require_unchanged(stored)
    assert "avahazard calibrate" in error.value.hint


@pytest.mark.parametrize("path_id", ["scey", "nants"])
def test_a_model_for_paths_gives_what_the_whole_one_does(database: str, path_id: str) -> None:
    _store(database, _found(ARMS), paths=("scey", "saugy"))
    (whole, everything), (small, found) = load_stored(database, "m"), load_for_paths(database, "m")
    assert found.fingerprint == data_fingerprint(everything)
    assert (whole.records_changed, small.records_changed) == (False, False)
    assert small.likelihood is None
    mine = of_path(everything, path_id)
    one, other = (path_hazard(fit, mine, path_id, None, [2e4], seed=3) for fit in (whole, small))
    for name in ("location", "scatter"):
        np.testing.assert_array_equal(
            getattr(one.avalanches, name), getattr(other.avalanches, name)
        )
    for curve, same in zip(one.avalanches.curves, other.avalanches.curves, strict=True):
        np.testing.assert_array_equal(curve.x, same.x)
    np.testing.assert_array_equal(one.draws.u, other.draws.u)
    assert one.rising == other.rising
    assert one.offset_unknown == other.offset_unknown == (path_id != "scey")
    told = [extrapolation(fit, path_id, 3e6) for fit in (whole, small)]
    assert told[0] == told[1]


def test_a_model_for_paths_on_records_that_changed_or_lack_a_profile(database: str) -> None:
    _store(database, _found(), paths=("scey",))
    with writing(database) as session:
        save_records(session, Records(events=(Event("E2", "saugy", runout_elevation_m=1100.0),)))
    assert not load_for_paths(database, "m")[0].records_changed  # another path's
    with writing(database) as session:
        save_records(session, Records(events=(Event("E3", "scey", runout_elevation_m=1100.0),)))
    assert load_for_paths(database, "m")[0].records_changed
    with writing(database) as session:
        session.execute(delete(ProfilePointTable).where(ProfilePointTable.path_id == "scey"))
    with pytest.raises(AvahazardError, match="No profile is stored for path scey"):
        load_for_paths(database, "m")


def test_a_users_effect_is_asked_for_again(database: str) -> None:
    own = Definition(
        "my-own", "", "", lambda _: Effect("my-own", (Parameter("k", "", 0.0, 0.0, 1.0),))
    )
    _store(database, _found(None, own), effect_file="raise SystemExit")
    with pytest.raises(AvahazardError, match="'my-own' from its user's file") as error:
        load_stored(database, "m")
    assert "--effect-file" in error.value.hint
    assert own in load_stored(database, "m", [own])[0].definitions
