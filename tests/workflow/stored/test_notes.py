"""One list of notes on a model: every command says all of it."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import text

from avahazard.store.results import document_checksum
from avahazard.store.session import reading, writing
from avahazard.store.tables import CalibrationTable
from avahazard.store.upkeep import check_database
from avahazard.workflow.compare import compare
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.export import export
from avahazard.workflow.friction import show_frictions
from avahazard.workflow.hazard import hazard
from avahazard.workflow.ladder import ladder
from avahazard.workflow.models import show_model
from avahazard.workflow.predict import predict
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import DiagnoseRequest, HazardRequest, ReportRequest, ZonesRequest
from avahazard.workflow.runout import run_model
from avahazard.workflow.stored.model import load_stored
from avahazard.workflow.stored.notes import model_notes
from avahazard.workflow.zones import zones

pytestmark = pytest.mark.usefixtures("drawn_little")

STALE = "the records have changed since base was calibrated."
UNCONVERGED = "the chains of base have not converged."
FEW = "base stands on 7 events only."
OTHER = "base was made with version 0.0.1 of this program"
PRIOR = "the records say little of log a: in base the prior speaks"
SPREAD = "paths differ by sd 0.20"
RECORDS = "records contradict themselves: e1."
ALL = (STALE, UNCONVERGED, FEW, OTHER, PRIOR, SPREAD, RECORDS)


def told_of(database: str) -> None:
    """Make the stored model `base` one of which there is everything to say but that it is stale."""
    with writing(database) as session:
        row = session.query(CalibrationTable).one()
        result = json.loads(json.dumps(row.result))
        result["n_events"] = 7
        result["diagnostics"]["converged"] = False
        result["prior_dominated"] = {"log a": {"sd_ratio": 0.9, "moved_sd": 0.2}}
        result["path_spread"] = {"sd": 0.2, "evidence": 5.0, "n_paths": 6, "effect": None}
        result["of_records"] = [RECORDS]
        settings = json.loads(json.dumps(row.settings))
        settings["made_with"]["versions"]["avahazard"] = "0.0.1"
        row.result, row.settings, row.converged = result, settings, False
        row.sha256 = document_checksum("base", result)
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


def test_the_error_of_speeds_of_an_earlier_version_is_told(snow_database: str) -> None:
    result = load_stored(snow_database, "base")[0].calibration
    (one, *_) = result.parameters.values()
    old = replace(result, parameters={**result.parameters, "speed_sigma": one})
    assert "track_sigma" not in in_words(model_notes(result, False, None))
    assert "base was calibrated with the error of speeds" in in_words(model_notes(old, False, None))


@pytest.mark.slow
def test_every_command_says_all_of_a_model(poor: str, snow_world: Path, tmp_path: Path) -> None:
    events = snow_world / "world" / "events.csv"
    path_id = hazard(poor, "base", HazardRequest(draws=200)).rows[0].path_id
    commands: dict[str, Callable[[], tuple[str, ...]]] = {
        "model": lambda: (*show_model(poor, "base").notes, UNCONVERGED),
        "predict": lambda: predict(poor, "base", events).notes,
        "runout": lambda: run_model(poor, path_id, "base", volume_m3=2e4).notes or (),
        "friction": lambda: show_frictions(poor, path_id, model="base").notes or (),
        "hazard": lambda: hazard(poor, "base", HazardRequest(draws=200)).notes,
        "ladder": lambda: ladder(poor).notes,
        "export": lambda: export(poor, "base", tmp_path / "bounds.csv").notes,
    }
    for command, notes in commands.items():
        found = in_words(notes())
        assert [note for note in ALL if note not in found] == [], command
    with (tmp_path / "bounds.csv").open(encoding="utf-8") as handle:
        for row in csv.DictReader(handle):
            assert [note for note in ALL if note not in row["notes"]] == []


def test_bounds_that_became_stale_since_are_exported_with_a_word(
    snow_database: str, tmp_path: Path
) -> None:
    hazard(snow_database, "base", HazardRequest(draws=200))
    assert STALE not in in_words(export(snow_database, "base", tmp_path / "a.csv").notes)
    with writing(snow_database) as session:
        session.execute(text("UPDATE events SET volume_m3 = 1.01 * volume_m3"))
    assert STALE in in_words(export(snow_database, "base", tmp_path / "a.csv").notes)
    assert STALE in (tmp_path / "a.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_long_commands_say_it_too(snow_database: str, tmp_path: Path) -> None:
    told_of(snow_database)
    fresh = [note for note in ALL if note != STALE]
    hazard(snow_database, "base", HazardRequest(draws=200))
    found = {
        "compare": compare(snow_database, "base").notes,
        "diagnose": diagnose_model(snow_database, "base", DiagnoseRequest(worlds=39)).notes,
        "zones": zones(snow_database, "base", ZonesRequest()).notes,
    }
    for command, notes in found.items():
        assert [note for note in fresh if note not in in_words(notes)] == [], command
    write_report(snow_database, "base", tmp_path / "base.html", ReportRequest())
    page = (tmp_path / "base.html").read_text(encoding="utf-8")
    assert "7 events only" in page
