"""The next step, from what is stored of models."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.notes import Note
from avahazard.records.collection import Event, Path, Profile, Records, data_fingerprint
from avahazard.results.base import Rows, plain
from avahazard.results.comparison import GroupError
from avahazard.results.diagnosis import Candidate, Diagnosis, FittedLaw, Measurement, Pair
from avahazard.store.records import save_records
from avahazard.store.results import (
    AVERAGE,
    COMPARISON,
    DIAGNOSIS,
    PathResult,
    begin_run,
    finish_run,
    save_model,
    save_paths,
    save_result,
)
from avahazard.store.session import reading, writing
from avahazard.workflow.database import init_database
from avahazard.workflow.next_step import StoredModels, after_import, next_step
from tests.results.samples import CALIBRATION, CANDIDATE
from tests.results.samples import COMPARISON as COMPARED
from tests.results.samples import DIAGNOSIS as VERDICT

RECORDS = Records((Path("p"),), (), (Event("e", path_id="p", runout_elevation_m=900.0),))
PROFILE = Profile("p", np.array([0.0, 1000.0, 2000.0]), np.array([2000.0, 1200.0, 800.0]))
ADEQUATE = replace(VERDICT, pairs=Rows())
LACKS_SEASON = replace(ADEQUATE, verdict="missing-effect", missing=("season",))


@pytest.fixture
def database(tmp_path: FilePath) -> str:
    name = str(tmp_path / "a.db")
    init_database(name)
    with writing(name) as session:
        save_records(session, RECORDS)
    return name


def put(
    database: str,
    name: str,
    *,
    parent: str | None = None,
    effects: tuple[str, ...] = (),
    error: float | None = None,
    diagnosis: Diagnosis | None = None,
    fingerprint: str = "",
    method: str = "marginal",
    alike: float | None = None,
    elpd: float | None = None,
    by_path: tuple[float, ...] = (),
) -> None:
    """Store a model with these findings; `alike` is its parent's error by its own groups."""
    found = replace(
        CALIBRATION,
        model=name,
        parent=parent,
        effects=effects,
        method=method,
        data_fingerprint=fingerprint or data_fingerprint(RECORDS),
    )
    with writing(database) as session:
        kept = {"specification": {"effects": effects}, "paths": ()}
        save_model(session, kept, {}, plain(found, keyed=True), {})
        if error is not None:
            runout = replace(COMPARED.held_out.runout, crps_m=error)
            groups = Rows(GroupError(f"P{k}", 10, crps) for k, crps in enumerate(by_path))
            found_so = {"runout": runout, "parent_crps_m": alike, "elpd_loo": elpd}
            held_out = replace(COMPARED.held_out, **found_so, groups=groups)
            compared = replace(COMPARED, held_out=held_out)
            save_result(session, COMPARISON, name, plain(compared, keyed=True))
        if diagnosis is not None:
            told = replace(diagnosis, model=name)
            save_result(session, DIAGNOSIS, name, plain(told, keyed=True))


def words(database: str, name: str, done: tuple[str, ...] = ()) -> list[str]:
    """The command of the next step, without the program."""
    step = next_step(database, name, done)
    assert step is not None
    program, *rest = shlex.split(step)
    assert program == "avahazard"
    return rest


def test_a_model_is_compared_then_diagnosed(database: str) -> None:
    put(database, "new")
    assert words(database, "new") == ["compare", "new"]
    put(database, "compared", error=60.0)
    assert words(database, "compared") == ["diagnose", "compared"]
    put(database, "adequate", error=60.0, diagnosis=ADEQUATE)
    # Without a profile there are no bounds to draw.
    step = next_step(database, "adequate")
    assert step == "avahazard report adequate -o adequate.html"
    assert "no design runout is possible; avahazard predict adequate FILE" in step.values["why"]
    assert next_step(database, "adequate", done=("report",)) is None


def test_what_is_missing_is_added_once(database: str) -> None:
    put(database, "base", error=60.0, diagnosis=LACKS_SEASON)
    assert words(database, "base") == ["add", "base", "season", "--as", "base+season"]
    put(database, "base+season", parent="base", effects=("season",), error=50.0)
    assert words(database, "base") == ["diagnose", "base+season"]


def test_a_named_effect_of_ones_own_comes_with_its_file(database: str) -> None:
    """Without it the step that was printed failed: there is no effect of that name."""
    own = replace(ADEQUATE, verdict="missing-effect", missing=("lake",))
    put(database, "base", error=60.0, diagnosis=replace(own, given_files={"lake": "my lake.py"}))
    asked = words(database, "base")
    assert asked == ["add", "base", "lake", "--as", "base+lake", "--effect-file", "my lake.py"]


def test_a_report_of_a_model_leads_to_that_of_the_model_to_use(database: str) -> None:
    put(database, "base", error=60.0, diagnosis=LACKS_SEASON)
    done = replace(ADEQUATE, missing=())
    put(database, "child", parent="base", effects=("season",), error=50.0, diagnosis=done)
    step = next_step(database, "base", done=("report",))
    assert step == "avahazard report child -o child.html"


def test_a_child_that_is_held_out_by_events_is_judged_by_these(database: str) -> None:
    lacks = replace(ADEQUATE, verdict="missing-effect", missing=("path-effect",))
    put(database, "base", error=60.0, diagnosis=lacks)
    child = {"parent": "base", "effects": ("path-effect",), "error": 62.0}
    put(database, "base+path-effect", **child, alike=80.0)
    assert words(database, "base") == ["diagnose", "base+path-effect"]
    put(database, "worse", **child, alike=61.0)
    assert words(database, "worse")[1] != "worse"


@pytest.mark.parametrize("lead", [5.0, 11.0])
def test_a_law_that_says_more_than_its_curve_is_written(database: str, lead: float) -> None:
    law = FittedLaw("hump", "elevation-hump", "change e^…", {}, 80.0, lead)
    gains = 85.0, 78.0, 72.0, 0.001, 40.0, 3.0, 0.001, 136.0, 121.0
    tried = Candidate("force:elevation", *gains, {}, "It varies.", (), laws=Rows([law]))
    lacks = replace(LACKS_SEASON, missing=(tried.effect,), candidates=Rows([tried]))
    put(database, "base", error=60.0, diagnosis=lacks)
    add = ["add", "base", tried.effect, "--as", f"base+{tried.effect}"]
    written = ["diagnose", "base", "--write-effect", "base-law.py"]
    assert words(database, "base") == (add if lead < 6.0 else written)
    if lead > 6.0:
        two = replace(tried, laws=Rows([law, replace(law, form="step", evidence=79.0)]))
        put(database, "alike", error=60.0, diagnosis=replace(lacks, candidates=Rows([two])))
        step = next_step(database, "alike")
        assert step is not None
        assert "its laws hump and step explain the records alike" in step.values["why"]
    put(database, "curve", parent="base", effects=(tried.effect,), error=50.0)
    assert words(database, "base") == ["diagnose", "curve"]


def test_a_child_that_is_worse_is_not_kept(database: str) -> None:
    put(database, "base", error=60.0, diagnosis=LACKS_SEASON)
    put(database, "child", parent="base", effects=("season",), error=61.0)
    step = next_step(database, "child")
    assert step is not None
    assert "has a larger held-out CRPS than base: do not use it for runouts." in step.values["why"]
    assert step == "avahazard report base -o base.html"
    assert words(database, "base") == words(database, "child")
    with reading(database) as session:
        assert StoredModels(session).best() == "base"


@pytest.mark.parametrize(
    ("by_path", "elpd", "kept"),
    [
        ((62.0, 59.0, 60.0), -862.0, True),
        ((62.0, 59.0, 60.0), -898.0, False),
        ((61.0, 61.1, 60.9), -862.0, True),
        ((62.0, 62.1, 61.9), -862.0, False),
        ((66.0, 62.0, 58.0), -862.0, True),
    ],
    ids=["within chance", "no better log score", "small", "certain and large", "large by chance"],
)
def test_a_rise_within_chance_is_weighed_against_the_log_score(
    database: str, by_path: tuple[float, ...], elpd: float, kept: bool
) -> None:
    base = {"error": 60.0, "elpd": -900.0, "by_path": (60.0,) * 3}
    put(database, "base", diagnosis=LACKS_SEASON, **base)
    put(
        database,
        "child",
        parent="base",
        effects=("season",),
        error=sum(by_path) / 3.0,
        elpd=elpd,
        by_path=by_path,
    )
    assert words(database, "base") == (
        ["diagnose", "child"] if kept else ["report", "base", "-o", "base.html"]
    )
    with reading(database) as session:
        assert StoredModels(session).best() == ("child" if kept else "base")


def test_effects_that_are_needed_together_are_added_together(database: str) -> None:
    pair = Pair(("covariate:depth", "season"), 12.5, 6.0, 0.01, 60.0, {})
    put(database, "a b", error=60.0, diagnosis=replace(LACKS_SEASON, pairs=Rows([pair])))
    name = "a b+covariate:depth+season"
    assert words(database, "a b") == ["add", "a b", "covariate:depth", "season", "--as", name]


def test_what_cannot_be_told_apart_nor_averaged_is_measured(database: str) -> None:
    useful = Measurement(Note("measure_runouts", n=50), 4.2)
    alike = replace(ADEQUATE, verdict="ambiguous", missing=("season", "speed:elevation"))
    put(database, "one", error=60.0, diagnosis=replace(alike, measure_next=Rows([useful])))
    assert next_step(database, "one") == "measure runouts of 50 more avalanches"


@pytest.mark.parametrize(("behind", "both"), [(4.0, True), (9.0, False)])
def test_what_is_far_behind_is_not_added_as_well(
    database: str, behind: float, *, both: bool
) -> None:
    leads = replace(CANDIDATE, effect="season")
    tried = [replace(leads, evidence_gain=20.0)]
    tried.append(replace(leads, effect="snow-type", evidence_gain=20.0 - behind))
    alike = replace(ADEQUATE, verdict="ambiguous", missing=("season", "snow-type"))
    put(database, "two", error=60.0, diagnosis=replace(alike, candidates=Rows(tried)))
    step = next_step(database, "two")
    assert step == "avahazard add two season --as two+season"
    assert ("Add each" in step.values["why"]) == both
    done = {"parent": "two", "effects": ("season",), "error": 50.0}
    put(database, "two+season", diagnosis=replace(ADEQUATE, missing=()), **done)
    for name in ("two", "two+season"):
        assert ("snow-type" in words(database, name)) == both


def test_else_each_of_them_is_added_and_all_are_averaged(database: str) -> None:
    with writing(database) as session:
        save_records(session, Records((), (PROFILE,), ()))
    now = data_fingerprint(replace(RECORDS, profiles=(PROFILE,)))
    alike = replace(ADEQUATE, verdict="ambiguous", missing=("season", "snow-type"))
    put(database, "two", error=60.0, diagnosis=alike, fingerprint=now)
    assert words(database, "two") == ["add", "two", "season", "--as", "two+season"]
    put(
        *(database, "two+season"),
        parent="two",
        effects=("season",),
        error=50.0,
        diagnosis=replace(ADEQUATE, missing=()),
        fingerprint=now,
    )
    for name in ("two", "two+season"):
        assert words(database, name) == ["add", "two", "snow-type", "--as", "two+snow-type"]
    # A child that is adequate is not said to lack anything.
    step = next_step(database, "two+season")
    assert step is not None
    assert str(step.values["why"]).startswith("two may lack snow-type instead of what two+season")
    put(
        *(database, "two+snow-type"),
        parent="two",
        effects=("snow-type",),
        error=51.0,
        diagnosis=replace(ADEQUATE, missing=()),
        fingerprint=now,
    )
    for name in ("two", "two+season", "two+snow-type"):
        step = next_step(database, name)
        assert step == "avahazard hazard two+season two+snow-type"
        assert "cannot determine which. Average them." in step.values["why"]
    with writing(database) as session:
        run, _ = begin_run(session, AVERAGE, "two+season", "key", {})
        save_paths(session, run, [PathResult(0, "p", ({"path_id": "p"},))])
        finish_run(session, run)
    for name in ("two", "two+season", "two+snow-type"):
        assert words(database, name)[:2] == ["report", "two+season"]
    assert next_step(database, "two", done=("report",)) is None


def test_what_no_effect_explains(database: str) -> None:
    unexplained = replace(ADEQUATE, verdict="unexplained", missing=("speed:elevation",))
    put(database, "one", error=60.0, diagnosis=unexplained)
    assert words(database, "one") == ["effect", "new", "one-effect.py"]
    by_column = replace(unexplained, missing=("covariate:depth",))
    put(database, "two", error=60.0, diagnosis=by_column)
    assert words(database, "two")[:3] == ["add", "two", "covariate:depth"]
    put(database, "three", error=60.0, diagnosis=replace(unexplained, missing=("path:p",)))
    assert words(database, "three")[:3] == ["add", "three", "path:p"]
    off = Note("speeds_off", factor=1.06, effect="force:slope")
    put(database, "four", error=60.0, diagnosis=replace(unexplained, notes=(off,)))
    found = next_step(database, "four")
    assert found is not None
    assert found.values["command"].startswith("measure speeds")


def test_other_records_ask_for_another_calibration(database: str) -> None:
    put(database, "old", effects=("season",), fingerprint="ab" * 32, error=10.0)
    assert words(database, "old") == ["calibrate", "old-2", "--with", "season"]
    put(database, "new", error=60.0)
    with reading(database) as session:
        assert StoredModels(session).best() == "new"


def test_on_other_records_the_model_to_use_is_made_again(database: str) -> None:
    old = {"fingerprint": "ab" * 32}
    put(database, "base", error=60.0, **old)
    put(database, "worse", parent="base", effects=("season",), error=65.0, **old)
    for name in ("base", "worse"):
        step = next_step(database, name)
        assert step == "avahazard calibrate base-2"
        assert step.values["why"].startswith("The records have changed since base was calibrated")
    assert after_import(database) == step
    put(database, "base-2", error=61.0)
    step = next_step(database, "worse")
    assert step == "avahazard diagnose base-2"
    assert step.values["why"].startswith("The records have changed since worse was calibrated.")


def test_the_papers_methods_go_straight_to_the_answer(database: str) -> None:
    put(database, "paper", method="metropolis")
    assert words(database, "paper")[0] == "report"


def test_after_an_import_comes_a_calibration_where_it_is_possible(database: str) -> None:
    assert after_import(database) is None  # its path has no profile
    with writing(database) as session:
        save_records(session, Records(profiles=(PROFILE,)))
    assert str(after_import(database)) == "avahazard calibrate base"


def test_after_an_import_a_model_on_other_records_is_made_anew(database: str) -> None:
    put(database, "first", fingerprint="other")
    assert str(after_import(database)) == "avahazard calibrate first-2"


def test_nothing_follows_an_import_without_events(tmp_path: FilePath) -> None:
    name = str(tmp_path / "none.db")
    init_database(name)
    assert after_import(name) is None
