"""What is stored of models."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import delete

from avahazard.effects.effect import Definition, Effect, Parameter
from avahazard.hazard.path_hazard import path_hazard
from avahazard.inference.fitted_model import Chains, FittedModel, fitted_model
from avahazard.inference.likelihood.assemble import assemble, build_effects, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Arms
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.calibration import calibrate_paper
from avahazard.inference.prediction import extrapolation
from avahazard.records.collection import (
    Event,
    Records,
    Speed,
    data_fingerprint,
    of_path,
    only_paths,
)
from avahazard.records.errors import AvahazardError
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.store.tables import ProfilePointTable
from avahazard.workflow.stored import (
    calibration_result,
    load_for_paths,
    load_stored,
    mode,
    on_events,
    require_unchanged,
    save_calibrated,
    summary,
)
from tests.criticism.studies import straight
from tests.workflow.twin import twin_records, twin_study
from tests.workflow.worlds import bowl

SPECIFICATION = Specification(law="power", scatter="volume", tails="student", centrifugal=False)
ARM = (0.1, 0.05, 0.2, 0.1 + 0.2)
ARMS = Arms({"turbulent-drag.drag": ARM}, {"turbulent-drag.drag": {"log sigma": 0.5}})


def _found(arms: Arms | None = None, *own: Definition) -> FittedModel:
    """A calibration with arbitrary draws on the twin, with effects and facts."""
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
        sampled=Chains(tuple(readable), tuple(unit for _, unit in readable.values()), values),
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
    (k,) = layout.tables
    assert layout.arms == ARMS
    assert (layout.slots[k].arm, layout.low[k], layout.high[k]) == (ARM, min(ARM), max(ARM))


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
    selected = of_path(everything, path_id)
    one, other = (
        path_hazard(fit, selected, path_id, None, [2e4], seed=3) for fit in (whole, small)
    )
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
    with pytest.raises(AvahazardError, match="an effect from a file of its user's") as error:
        load_stored(database, "m")
    assert "--effect-file" in error.value.hint
    assert own in load_stored(database, "m", own=[own])[0].definitions


def _calibrated(draws: np.ndarray, offsets: Mapping[str, np.ndarray], **others: Any) -> FittedModel:
    names = ("a", "sigma")[: draws.shape[2]]
    keys = ("path-effect",) if offsets else ()
    specification = Specification(law="constant", effects=keys)
    records = straight(7)
    if offsets:
        on_path = tuple(Event(f"e{i}", "B", runout_x_m=1000.0, volume_m3=1e4) for i in range(7))
        records = bowl(events=on_path)
    posterior = assemble(build_observations(records), specification, {})
    known = draws.reshape(-1, draws.shape[2])
    rest = len(posterior.layout.slots) - known.shape[1]
    others_drawn = np.random.default_rng(0).normal(0.5, 0.01, (len(known), rest))
    model = fitted_model(posterior, np.column_stack([known, others_drawn]), offsets)
    found = Chains(names, ("", "")[: len(names)], draws)
    return replace(model, sampled=found, **others)


def test_summary_of_known_draws() -> None:
    draws = np.arange(101.0)
    found = summary(draws, "m")
    assert (found.mean, found.q05, found.q95, found.unit) == (50.0, 5.0, 95.0, "m")
    assert found.sd == pytest.approx(np.sqrt(101 * 102 / 12))


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e6])
def test_the_mode_of_a_gamma_distribution(scale: float) -> None:
    draws = np.random.default_rng(1).gamma(4.0, scale, 40_000)
    # Its mode is (k - 1) θ = 3, its mean 4.
    assert mode(draws) == pytest.approx(3.0 * scale, rel=0.12)
    assert mode(-draws) == pytest.approx(-3.0 * scale, rel=0.12)


def test_a_long_tail_hardly_moves_the_mode() -> None:
    draws = np.random.default_rng(2).lognormal(0.0, 1.5, 40_000)
    # The mode is 0.1, the median 1, the mean 3.1.
    assert 0.0 < mode(draws) < 0.5


def test_the_mode_of_a_constant() -> None:
    assert mode(np.ones(100)) == 1.0
    assert mode(np.full(100, 0.1)) == 0.1


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_the_mode_at_the_ends_of_what_a_float_holds(scale: float) -> None:
    draws = np.random.default_rng(1).gamma(4.0, 1.0, 40_000)
    assert mode(draws * scale) == pytest.approx(mode(draws) * scale, rel=1e-9)
    far = np.concatenate([np.full(90, 2.0) + 1e-12 * np.arange(90), np.full(10, 1e300)])
    assert mode(far) == pytest.approx(2.0)


def test_parameters_offsets_and_settings() -> None:
    draws = np.random.default_rng(3).normal(0.5, 0.1, (4, 500, 2))
    found = _calibrated(draws, {"B": draws[..., 0].ravel() - 0.5}, left_out={"without a volume": 2})
    result = calibration_result(found, "m", Records(), seed=5, parent="p")
    assert list(result.parameters) == ["a", "sigma", "path:B"]
    assert result.parameters["path:B"].unit == "log friction"
    assert result.parameters["a"].mean == pytest.approx(draws[..., 0].mean())
    kept = ("model", "parent", "law", "effects", "n_events", "seed")
    assert [getattr(result, key) for key in kept] == ["m", "p", "constant", ("path-effect",), 5, 5]
    assert result.data_fingerprint == data_fingerprint(Records())
    assert (result.chains, result.draws) == (4, 500)
    assert result.diagnostics.converged
    # Draws about 0.5 are of a log here: a friction that units in feet would give.
    (note,) = result.notes
    assert "friction of m is 1.6" in note
    assert "in feet" in note


def test_chains_apart_are_said_not_to_have_converged() -> None:
    draws = np.random.default_rng(4).normal(0.5, 0.1, (4, 500, 1)) + np.arange(4)[:, None, None]
    result = calibration_result(_calibrated(draws, {}), "m", Records(), seed=0)
    assert result.diagnostics.converged is False
    assert result.diagnostics.rhat_max > 1.5
    assert "have not converged" in result.notes[0]
