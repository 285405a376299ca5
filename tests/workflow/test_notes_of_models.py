"""One list of notes on a model: every command says all of it."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from sqlalchemy import text

from avahazard.criticism.diagnosis.refits import refit
from avahazard.effects.catalogue import definition
from avahazard.inference.fitted_model import FittedModel, exact_volumes, fitted_model
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import VolumeNodes, bounded
from avahazard.notes import Note, grouped
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.report.language import language_of
from avahazard.store.records import save_records
from avahazard.store.session import reading, writing
from avahazard.store.tables import CalibrationTable
from avahazard.store.upkeep import check_database
from avahazard.workflow.calibrate import calibrate, show_model
from avahazard.workflow.compare import compare, ladder, predict
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.export import export
from avahazard.workflow.friction import show_frictions
from avahazard.workflow.hazard import hazard, zones
from avahazard.workflow.path import run_block
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    FrictionRequest,
    HazardRequest,
    ReportRequest,
    RunoutRequest,
    ZonesRequest,
)
from avahazard.workflow.stored import prior_notes, record_notes, volume_notes
from tests.criticism.lengths import lengths
from tests.inference import studies
from tests.workflow.worlds import bowl, height, known_stops

pytestmark = pytest.mark.usefixtures("drawn_little")

STALE = "the records have changed since base was calibrated."
UNCONVERGED = "the chains of base have not converged."
FEW = "base is based on 7 events only."
OTHER = "base was made with version 0.0.1 of this program"
PRIOR = "log a is weakly identified: in base it is prior-dominated"
SPREAD = "paths seem to differ by a standard deviation of 0.20"
RECORDS = "records contradict themselves: e1."
ALL = (STALE, UNCONVERGED, FEW, OTHER, PRIOR, SPREAD, RECORDS)


def told_of(database: str) -> None:
    """Make the stored model `base` one of which there is everything to say but that it is stale."""
    with writing(database) as session:
        row = session.query(CalibrationTable).one()
        result = json.loads(json.dumps(row.result))
        result["n_events"] = 7
        result["diagnostics"]["converged"] = False
        remedy = Note("too_few_paths", n=6)
        notes = (
            Note("prior_dominated", parameter="log a", model="base", width=0.9, moved=0.2),
            Note("paths_differ", sd=0.2, nats=5.0, model="base", remedy=remedy),
        )
        result["notes"] = [*(note.stored() for note in notes), RECORDS]
        settings = json.loads(json.dumps(row.settings))
        settings["made_with"]["versions"]["avahazard"] = "0.0.1"
        row.result, row.settings, row.converged = result, settings, False
        row.sha256 = row.digest()
    with reading(database) as session:
        assert check_database(session) == []


@pytest.fixture
def poor(snow_database: str) -> str:
    """Give a database whose model is as poor as can be, on records that have changed."""
    told_of(snow_database)
    with writing(snow_database) as session:
        session.execute(text("UPDATE events SET volume_m3 = 1.01 * volume_m3"))
    return snow_database


def in_words(notes: tuple[str, ...]) -> str:
    return "\n".join(notes)


@pytest.mark.slow
def test_every_command_says_all_of_a_model(
    poor: str, snow_world: FilePath, tmp_path: FilePath
) -> None:
    events = snow_world / "world" / "events.csv"
    path_id = hazard(poor, "base", HazardRequest(draws=200)).rows[0].path_id
    commands: dict[str, Callable[[], tuple[str, ...]]] = {
        "model": lambda: (*show_model(poor, "base").notes, UNCONVERGED),
        "predict": lambda: predict(poor, "base", events).notes,
        "runout": lambda: (
            run_block(poor, path_id, RunoutRequest(model="base", volume_m3=2e4)).notes or ()
        ),
        "friction": lambda: (
            show_frictions(poor, path_id, FrictionRequest(model="base")).notes or ()
        ),
        "hazard": lambda: hazard(poor, "base", HazardRequest(draws=200)).notes,
        "ladder": lambda: ladder(poor).notes,
        "export": lambda: export(poor, "base", tmp_path / "bounds.csv").notes,
    }
    for command, notes in commands.items():
        found = in_words(notes())
        assert [note for note in ALL if note not in found] == [], command
    with (tmp_path / "bounds.csv").open(encoding="utf-8") as handle:
        for row in csv.DictReader(handle):
            # In a file notes are sentences, with capitals.
            told = row["notes"].lower()
            assert [note for note in ALL if note.lower() not in told] == []


def test_bounds_that_became_stale_since_are_exported_with_a_word(
    snow_database: str, tmp_path: FilePath
) -> None:
    hazard(snow_database, "base", HazardRequest(draws=200))
    assert STALE not in in_words(export(snow_database, "base", tmp_path / "a.csv").notes)
    with writing(snow_database) as session:
        session.execute(text("UPDATE events SET volume_m3 = 1.01 * volume_m3"))
    assert STALE in in_words(export(snow_database, "base", tmp_path / "a.csv").notes)
    assert STALE[1:] in (tmp_path / "a.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_long_commands_say_it_too(snow_database: str, tmp_path: FilePath) -> None:
    told_of(snow_database)
    fresh = [note for note in ALL if note != STALE]
    hazard(snow_database, "base", HazardRequest(draws=200))
    found = {
        "compare": compare(snow_database, "base").notes,
        "diagnose": diagnose_model(snow_database, "base", DiagnoseRequest()).notes,
        "zones": zones(snow_database, "base", ZonesRequest(no_drag=True)).notes,
    }
    # What is missing may be what the paths differ by.
    kept = [note for note in fresh if not note.startswith("paths seem to differ")]
    for command, notes in found.items():
        told = kept if command == "diagnose" else fresh
        assert [note for note in told if note not in in_words(notes)] == [], command
    write_report(snow_database, "base", tmp_path / "base.html", ReportRequest())
    page = (tmp_path / "base.html").read_text(encoding="utf-8")
    assert "7 events only" in page


def events() -> tuple[Event, ...]:
    return known_stops(volume_m3=3e4)


def notes(records: Records) -> tuple[str, ...]:
    return record_notes(records, build_observations(records).sites)


def cliff(depth_m: float) -> Records:
    """The bowl with a step of that depth on 20 m, and points that are said to be exact."""
    x = np.linspace(0.0, 1900.0, 96)
    y = height(x) + depth_m * (x < 500.0)
    profile = Profile("B", x, y, elevation_sigma_m=np.full(len(x), 0.5))
    return Records((Path("B"),), (profile,), events())


def test_right_records_need_no_note() -> None:
    assert notes(bowl(events=events())) == ()


def test_a_path_that_misses_its_terrain_is_told_with_the_place() -> None:
    (note,) = notes(cliff(120.0))
    assert note.startswith(
        "B: the path that the block runs on misses the points of its profile by "
    )
    place = float(note.split("at x = ")[1].split(" m")[0])
    assert 400.0 < place < 600.0


def test_an_error_of_the_points_is_no_misfit() -> None:
    rough = cliff(0.0)
    noise = np.random.default_rng(1).normal(0.0, 5.0, 96)
    (profile,) = rough.profiles
    told = replace(profile, y_m=profile.y_m + noise, elevation_sigma_m=np.full(len(noise), 5.0))
    assert notes(replace(rough, profiles=(told,))) == ()


def test_values_that_cannot_all_be_true_are_told(database: str) -> None:
    wrong = Event(
        "wrong",
        "B",
        runout_x_m=900.0,
        volume_m3=1e6,
        volume_rel_sigma=0.1,
        deposit_length_m=10.0,
        deposit_width_m=10.0,
        deposit_thickness_m=2.0,
    )
    before = Event("before", "B", runout_x_m=900.0, left_profile=True, volume_m3=1e4)
    records = bowl(events=(*events(), wrong, before))
    note, of_place = notes(records)
    assert note.startswith(
        "wrong: the record of this event contradicts itself: volume_m3 is 1e+06; "
    )
    assert "accepted would be about 100" in note
    assert "before: the record of this event contradicts itself: runout_x_m is 900" in of_place
    for code in ("de", "fr", "it"):
        told = language_of(code).note(note)
        assert "accepted" not in told
        assert "half of length" not in told
        assert "left_profile 0, or" not in language_of(code).note(of_place)
        assert "wrong" in told
    six = tuple(replace(wrong, event_id=f"w{k}", date=f"195{k}") for k in range(6))
    many = notes(replace(records, events=six))
    assert len(many) == 6
    (one,) = grouped(many)
    assert one.startswith("w0, w1, w2 and 3 more: the record of this event contradicts itself")
    # It is stored with the model, and everything that shows the model says it.
    with writing(database) as session:
        save_records(session, records)
    assert note in calibrate(database, "m", CalibrateRequest(chains=2, draws=50)).notes
    assert show_model(database, "m").notes.count(note) == 1


def test_stops_over_the_limit_of_sight_are_told_but_not_those_across_the_valley() -> None:
    x = np.linspace(0.0, 2000.0, 101)
    valley = Profile("V", x, 500.0 + np.abs(x - 1400.0) * np.where(x < 1400.0, 0.5, 0.3))
    (path,) = (Path("V", observed_below_m=600.0),)

    def told(*events: Event) -> tuple[str, ...]:
        return record_notes(Records((path,), (valley,), events), ())

    seen = Event("seen", "V", runout_x_m=1300.0, runout_sigma_m=10.0, volume_m3=1e4)
    across = Event("across", "V", runout_x_m=1900.0, runout_sigma_m=10.0, volume_m3=1e4)
    barely = Event("barely", "V", runout_x_m=1180.0, runout_sigma_m=10.0, volume_m3=1e4)
    high = Event("high", "V", runout_x_m=900.0, runout_sigma_m=10.0, volume_m3=1e4)
    assert told(seen, across, barely) == ()
    (note,) = told(seen, high, across)
    assert note.startswith("V: 1 record stops above observed_below_m (600 m)")
    assert "event high, at 735 m" in note
    for code in ("de", "fr", "it"):
        assert language_of(code).note(note) != note


def test_an_avalanche_that_is_there_twice_is_told() -> None:
    first, *others = events()
    again = replace(first, event_id="again")
    (note,) = notes(bowl(events=(first, *others, again)))
    assert note.startswith(f"{first.event_id} = again: alike in path, day and stop")
    for code in ("de", "fr", "it"):
        told = language_of(code).note(note)
        assert "again" in told
        assert "alike" not in told


def _model(volumes: VolumeNodes, law: str = "exponential") -> FittedModel:
    observations = replace(studies.observations(), volumes=volumes)
    posterior = studies.posterior(observations, law=law)
    return fitted_model(posterior, studies.near(posterior)[None], {})


def test_of_lognormal_volumes_nothing_is_said() -> None:
    assert volume_notes(_model(studies.observations().volumes), "m") == ()


def test_the_largest_volume_is_told() -> None:
    (note,) = volume_notes(_model(bounded(studies.observations().volumes, 812345.0)), "m")
    assert note.startswith("m takes no true volume to be larger than 810,000 m3")


def test_where_volumes_do_not_count_or_have_no_error_nothing_is_said() -> None:
    volumes = bounded(studies.observations().volumes, 1e6)
    assert volume_notes(_model(volumes, "constant"), "m") == ()
    observations = studies.observations()
    all_known = np.nan_to_num(observations.columns.log_volume, nan=10.0)
    columns = replace(observations.columns, log_volume=all_known)
    known = replace(observations, columns=columns, volumes=volumes)
    assert volume_notes(_model(exact_volumes(known)), "m") == ()


def test_bends_that_their_prior_holds_are_no_fault() -> None:
    key = "covariate:column_1"
    fit = refit(build_observations(lengths(60)), Specification(law="power"), {}, (key,))
    model = replace(fit.at_mode(), draws=fit.sample, facts=fit.facts)
    of_bends = [note for note in prior_notes(model, "m") if "bend" in note]
    assert of_bends
    model = replace(model, definitions=(definition(key),))
    assert [note for note in prior_notes(model, "m") if "bend" in note] == []
