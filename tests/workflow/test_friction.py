"""What `friction` reports of the records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import N_REPLICATES, back_calculate
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.records.errors import AvahazardError
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.friction import (
    apparent_friction,
    fit_laws,
    friction_view,
    from_reference,
    show_frictions,
)
from avahazard.workflow.requests import FrictionRequest
from avahazard.workflow.stored import load_stored
from tests.telling import untold
from tests.workflow.twin import FEW_PATHS
from tests.workflow.worlds import bowl, known_stops


def _stored(database: str, records: Records) -> None:
    with writing(database) as session:
        save_records(session, records)


def test_what_is_shown(database: str) -> None:
    events = tuple(
        replace(event, volume_m3=1e4 * (i + 1))
        for i, event in enumerate(known_stops(runout_sigma_m=5))
    )
    _stored(database, bowl(1900.0, events))
    found = show_frictions(database, "B", FrictionRequest(kappa=8.0))
    assert [event.path_id for event in found.events] == ["B"] * 10
    whole, one = found.density
    assert (whole.path_id, one.path_id, one.kappa, one.n) == ("all", "B", 8.0, 10)
    assert whole.pdf == one.pdf
    inside = ~np.asarray(one.extrapolated)
    assert np.array(one.mu)[inside].min() >= 0.418
    assert np.array(one.mu)[inside].max() <= 0.702
    check = found.perturbation
    assert (check.n_replicates, check.n_events, check.law) == (N_REPLICATES, 10, "exponential")
    a = check.parameters["a"]
    assert a.mean == pytest.approx(a.value, abs=3.0 * a.sd)
    assert 0.0 < a.sd < a.se


def test_without_volumes_there_is_no_law(database: str) -> None:
    _stored(database, bowl(1900.0, known_stops()))
    check = show_frictions(database).perturbation
    assert (check.law, check.parameters) == (None, {})
    assert check.mu_sd_median > 0.0


def test_a_terrace_makes_f_jump(database: str) -> None:
    # The block stops on the terrace or passes its edge and runs far down.
    x = np.linspace(0.0, 1600.0, 161)
    slope = np.select([x < 500.0, x < 650.0, x < 1000.0], [0.7, 0.0, 0.7], 0.1)
    y = 1200.0 - np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(x))])
    edge = Event("edge", "T", runout_x_m=800.0)
    _stored(database, Records((Path("T"),), (Profile("T", x, y),), (edge,)))
    found = show_frictions(database)
    (event,) = found.events
    assert event.status == "jump"
    assert event.mu_low < event.mu < event.mu_high


def test_a_path_withoutknown_stops(database: str) -> None:
    _stored(database, bowl())
    with pytest.raises(AvahazardError, match="no events on B"):
        show_frictions(database, "B")


def test_a_model_without_effects_is_the_block_by_itself(twin_models: str) -> None:
    by_model = show_frictions(twin_models, FEW_PATHS[0], FrictionRequest(model="plain"))
    alone = show_frictions(twin_models, FEW_PATHS[0])
    assert by_model.model == "plain"
    assert by_model.notes == ("the chains of plain have not converged.",)
    assert [event.mu for event in by_model.events] == [event.mu for event in alone.events]
    for event in by_model.events:
        if event.mu is not None:
            assert event.mu_reference == pytest.approx(event.mu)
    assert alone.model is None
    assert alone.events[0].mu_reference is None


def test_drag_takes_its_part_of_the_friction(twin_models: str, tmp_path: FilePath) -> None:
    picture = tmp_path / "law.svg"
    found = show_frictions(twin_models, None, FrictionRequest(model="drag", plot=picture))
    assert {event.path_id for event in found.events} == set(FEW_PATHS)
    alone = {event.event_id: event.mu for event in show_frictions(twin_models).events}
    pairs = [(e.mu, alone[e.event_id]) for e in found.events if e.mu and alone[e.event_id]]
    assert len(pairs) > 20
    assert all(mu < plain for mu, plain in pairs)
    # As the report has it: its points and this table are one.
    report = apparent_friction(load_stored(twin_models, "drag")[0])[0].mu
    np.testing.assert_array_equal([event.mu or np.nan for event in found.events], report)
    assert "<svg" in picture.read_text(encoding="utf-8")


def test_a_name_that_is_no_picture_is_refused_first(twin_models: str, tmp_path: FilePath) -> None:
    with pytest.raises(AvahazardError, match="not the name of a picture"):
        show_frictions(twin_models, None, FrictionRequest(model="nothing", plot=tmp_path / "a.txt"))
    with pytest.raises(AvahazardError, match="model nothing"):
        show_frictions(twin_models, None, FrictionRequest(model="nothing"))


DRAG = definition("turbulent-drag").build({})
SIGMA, STRENGTH, N = 0.1, 0.004, 180
X = np.arange(0.0, 3601.0, 30.0)
PROFILE = Profile("p", X, 2500.0 - 0.9 * X + 1.2e-4 * X**2)


def world(offset: float = 0.0) -> tuple[FittedModel, np.ndarray]:
    """Events stopped by drag and a friction that is known, and the model that they come from."""
    rng = np.random.default_rng(4)
    volume = np.exp(rng.uniform(np.log(2e3), np.log(2e5), N))
    log_mu = np.log(0.5) - 1e-6 * volume + SIGMA * rng.standard_normal(N)
    events = [
        Event(f"e{k}", path_id="p", volume_m3=v, runout_x_m=1.0) for k, v in enumerate(volume)
    ]
    observations = build_observations(Records((Path("p"),), (PROFILE,), tuple(events[:1])))
    strength = {"turbulent-drag": np.array([STRENGTH])}
    curve = predict_records(observations, (DRAG,), strength).curve
    x, _, status = curve.at(np.exp(log_mu + offset)[None, :])
    assert (status == 0).all()
    records = Records(
        (Path("p"),),
        (PROFILE,),
        tuple(
            Event(e.event_id, path_id="p", volume_m3=e.volume_m3, runout_x_m=float(place))
            for e, place in zip(events, x[0], strict=True)
        ),
    )
    slot = STRENGTH / DRAG.parameters[0].prior_sd
    draws = np.tile([np.log(0.5), 1.0, np.log(SIGMA), slot], (50, 1))
    posterior = Posterior(build_observations(records), Specification(), (DRAG,))
    offsets = {"p": np.full(50, offset)} if offset else {}
    return fitted_model(posterior, draws, offsets), np.exp(log_mu)


def inside(model: FittedModel, mu: np.ndarray) -> float:
    view = friction_view(model)
    assert view is not None
    assert view.scatter is not None
    log_volume = model.observations.columns.log_volume
    low, high = (np.interp(log_volume, np.log(view.volume), view.scatter[k]) for k in (0, 3))
    return float(np.mean((mu >= low) & (mu <= high)))


@pytest.mark.parametrize("offset", [0.0, 0.15])
def test_nine_in_ten_events_lie_in_the_band_of_an_adequate_model(offset: float) -> None:
    model, mu = world(offset)
    found = apparent_friction(model)[0].mu * np.exp(-from_reference(model))
    assert np.nanmax(np.abs(found / mu - 1.0)) < 0.01
    assert found.min() > MU[0]
    assert inside(model, found) == pytest.approx(0.9, abs=0.05)


def test_friction_without_the_drag_that_was_at_work_would_lie_outside() -> None:
    model, _ = world()
    plain = back_calculate(model.observations, predict_records(model.observations, (), {})).mu
    assert inside(model, plain) < 0.3


def _straight(volume: np.ndarray, mu: np.ndarray) -> Records:
    return Records(
        events=tuple(
            Event(str(i), fall_height_m=1000.0 * m, runout_length_m=1000.0, volume_m3=v)
            for i, (v, m) in enumerate(zip(volume, mu, strict=True))
        )
    )


def test_a_law_is_given_back_and_leads(database: str) -> None:
    volume = np.geomspace(1e3, 1e6, 30)
    mu = 1.07 * volume**-0.065
    with writing(database) as session:
        save_records(session, _straight(volume, mu))
    found = fit_laws(database)
    fits = {entry.law: entry for entry in found.rows}
    assert fits["power"].parameters["alpha"].value == pytest.approx(1.07)
    assert fits["power"].parameters["beta"].value == pytest.approx(0.065)
    assert fits["exponential"].parameters["n"].unit == "1/m3"
    assert min(fits.values(), key=lambda entry: entry.aic).law == "power"
    # A power law fixes no volume at which friction bends.
    assert "rational" not in fits
    assert any("rational" in note for note in found.notes)


def test_events_without_a_volume_are_counted(database: str) -> None:
    volume = np.array([1e3, 1e4, 1e5, 2e5])
    records = _straight(volume, np.array([0.5, 0.45, 0.4, 0.42]))
    bare = Event("bare", fall_height_m=500.0, runout_length_m=900.0)
    with writing(database) as session:
        save_records(session, Records(events=(*records.events, bare)))
    found = fit_laws(database)
    assert {entry.n_events for entry in found.rows} == {4}
    assert untold(found.notes[-1], 1, 5) == []


def test_no_volume_at_all(database: str) -> None:
    bare = Event("bare", fall_height_m=500.0, runout_length_m=900.0)
    with writing(database) as session:
        save_records(session, Records(events=(bare,)))
    with pytest.raises(AvahazardError, match="there are none"):
        fit_laws(database)
