"""What `friction` tells of the records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.inference.paper.apparent import N_REPLICATES
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.friction import show_frictions
from avahazard.workflow.model_friction import apparent_friction
from avahazard.workflow.stored.model import load_stored
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
    found = show_frictions(database, "B", 8.0)
    assert [event.path_id for event in found.events] == ["B"] * 10
    assert found.jumps == ()
    whole, one = found.density
    assert (whole.path_id, one.path_id, one.kappa, one.n) == ("all", "B", 8.0, 10)
    assert whole.pdf == one.pdf
    inside = ~np.asarray(one.extrapolated)
    assert np.array(one.mu)[inside].min() >= 0.418
    assert np.array(one.mu)[inside].max() <= 0.702
    check = found.perturbation
    assert (check.n_replicates, check.n_events, check.law) == (
        N_REPLICATES,
        10,
        "exponential",
    )
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
    (jump,) = found.jumps
    assert jump.path_id == "T"
    assert jump.jump_m > 100.0
    assert event.mu_low - 0.003 < jump.mu < event.mu_high


def test_a_path_withoutknown_stops(database: str) -> None:
    _stored(database, bowl())
    with pytest.raises(AvahazardError, match="Path B has no events"):
        show_frictions(database, "B")


def test_a_model_without_effects_is_the_block_by_itself(twin_models: str) -> None:
    by_model = show_frictions(twin_models, FEW_PATHS[0], model="plain")
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
    found = show_frictions(twin_models, model="drag", plot=picture)
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
        show_frictions(twin_models, model="nothing", plot=tmp_path / "a.txt")
    with pytest.raises(AvahazardError, match="model nothing"):
        show_frictions(twin_models, model="nothing")
