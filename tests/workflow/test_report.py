"""Reports of every kind of model and record."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.report.html.brief import path_cards
from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.results.hazard import HazardRow
from avahazard.store.results import BOUNDS, latest_documents
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.hazard import hazard
from avahazard.workflow.path import run_block
from avahazard.workflow.report import gather, write_report
from avahazard.workflow.requests import (
    CalibrateRequest,
    HazardRequest,
    ReportRequest,
    RunoutRequest,
)
from tests.criticism.lengths import as_csv, lengths
from tests.workflow.worlds import height

pytestmark = pytest.mark.usefixtures("drawn_little")

Write = Callable[[str, str], Path]


@pytest.fixture
def copied(report_database: str, tmp_path: Path) -> str:
    """Give a database that may be written to."""
    return str(shutil.copy(report_database, tmp_path / "copy.db"))


@pytest.fixture(scope="module")
def content(report_database: str) -> ReportContent:
    """Give what the report of `m` is made of."""
    return gather(report_database, "m", ReportRequest())


def test_equal_databases_give_equal_files(report_database: str, tmp_path: Path) -> None:
    told: list[float] = []
    one, other = tmp_path / "one.html", tmp_path / "other.html"
    document = write_report(
        report_database, "m", one, ReportRequest(), lambda _what, share: told.append(share)
    )
    other.write_text("an older one")
    write_report(report_database, "m", other, ReportRequest())
    assert one.read_bytes() == other.read_bytes()
    assert document.to_dict() == {
        "model": "m", "file": str(one), "bytes": one.stat().st_size, "n_paths": 3, "n_events": 61,
        "lacking": [], "notes": list(document.notes),
        "next": "avahazard add m season --as m+season",
    }  # fmt: skip
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert {file.name for file in tmp_path.iterdir()} == {"one.html", "other.html"}


def test_it_shows_what_is_stored(report_database: str, content: ReportContent) -> None:
    with reading(report_database) as session:
        stored = latest_documents(session, BOUNDS, "m")
    assert stored is not None
    assert content.rows == [HazardRow.from_dict(document) for document in stored]
    assert content.comparison is not None
    assert content.diagnosis is not None
    paths = {view.path.path_id: view for view in content.paths}
    assert [len(paths[key].rows) for key in ("scey", "saugy", "nants")] == [2, 0, 2]
    assert paths["scey"].plan is not None
    assert paths["scey"].plan.ground is not None
    assert paths["scey"].zones is not None
    assert paths["nants"].plan is not None
    assert paths["nants"].plan.crs is None
    assert paths["saugy"].plan is None
    assert {row.coefficients for row in paths["scey"].alpha_beta} == {"norway", "austria"}


def test_the_brief_has_an_average_and_what_each_model_says(copied: str) -> None:
    calibrate(copied, "other", CalibrateRequest(chains=2, draws=100))
    for names in (["m", "other"], ["other", "m"]):
        hazard(copied, names, HazardRequest(paths=["scey"], draws=200))
    content = gather(copied, "m", ReportRequest())
    (row,) = content.averages
    # The latest.
    assert [one.model for one in row.by_model] == ["other", "m"]
    names = [line[0] for card in path_cards(content)[0] for line in card.lines]
    k = names.index("100*, averaged")
    assert [name.split(" (")[0] for name in names[k + 1 : k + 3]] == ["other", "m"]
    assert "100*, averaged" in render(content)


def test_predictions_hold_most_records_and_friction_its_median(content: ReportContent) -> None:
    inside = [
        e.predicted[0] <= e.observed_m <= e.predicted[2]
        for e in content.events
        if e.predicted is not None and e.observed_m is not None
    ]
    assert len(inside) > 50
    assert 0.75 < np.mean(inside) < 1.0
    view = content.friction
    assert view is not None
    assert view.scatter is not None
    assert np.all(np.diff(np.vstack([view.scatter[:2], view.law[1], view.scatter[2:]]), axis=0) > 0)
    # The median curve is the law at the posterior's middle.
    a, n = (np.median(content.draws[key]) for key in ("a", "n"))
    np.testing.assert_allclose(view.law[1], a * np.exp(-n * view.volume), rtol=0.02)


def test_speeds_are_those_of_the_command_runout(
    report_database: str, content: ReportContent
) -> None:
    (scey,) = (view for view in content.paths if view.path.path_id == "scey")
    for row, x, speed in scey.speeds:
        run = run_block(report_database, "scey", RunoutRequest(model="m", volume_m3=row.volume_m3))
        assert x[-1] == pytest.approx(run.runout_x_m)
        assert speed.max() == pytest.approx(run.speed_max_m_s, rel=0.01)


@pytest.mark.parametrize(
    "options",
    [
        {"method": "gibbs"},
        {"method": "metropolis"},
        {"with_": ["release-elevation"], "scatter": "volume", "tails": "student"},
        pytest.param(
            {"law": "constant", "distribution": "normal", "without": ["centrifugal"]},
            marks=pytest.mark.slow,
        ),
        pytest.param({"with_": ["turbulent-drag"], "law": "rational"}, marks=pytest.mark.slow),
    ],
    ids=["gibbs", "metropolis", "effects", "normal", "drag"],
)
def test_every_kind_of_model(copied: str, options: dict[str, Any]) -> None:
    calibrate(copied, "other", CalibrateRequest(chains=2, draws=100, **options))
    hazard(copied, "other", HazardRequest(volumes=[2e4], paths=["scey"], draws=200))
    content = gather(copied, "other", ReportRequest())
    marginal = options.get("method", "marginal") == "marginal"
    assert content.lacking.keys() - {"zones"} == {"comparison", "diagnosis"}
    # What the note advises is not refused.
    assert ("zones" in content.lacking) == (options.get("method") != "metropolis")
    drag = "turbulent-drag" in options.get("with_", ())
    assert str(content.lacking.get("zones", "--no-drag")).endswith("--no-drag") != drag
    assert ("avahazard diagnose other" in content.lacking["diagnosis"]) == marginal
    assert len(content.ladder) == 2
    assert set(content.physics) == set(options.get("with_", ()))
    assert content.friction is not None
    assert (content.friction.scatter is None) == (options.get("method") == "metropolis")
    predicted = [e.predicted for e in content.events if e.predicted is not None]
    assert len(predicted) > 50
    assert np.all(np.diff(np.array(predicted), axis=1) > 0)
    text = render(content)
    assert "was not compared" in text or "method metropolis" in text
    assert "avahazard compare" not in text


def test_events_without_a_profile(database: str, write: Write) -> None:
    import_files(database, [write("events.csv", as_csv(lengths(30)))])
    calibrate(database, "r", CalibrateRequest(law="power", chains=2, draws=100))
    content = gather(database, "r", ReportRequest())
    assert content.paths == ()
    assert {e.coordinate for e in content.events} == {"length"}
    assert "No path has a profile" in content.lacking["rows"]
    assert "zones" not in content.lacking
    assert 'id="figure-predicted-length"' in render(content)
    told = write_report(database, "r", write("report.html", ""), ReportRequest())
    assert sum("No path has a profile" in words for words in told.lacking) == 1
    assert "the chains of r have not converged." in told.notes


def test_one_path_with_events_that_left_it_and_bounds_beyond(database: str, write: Write) -> None:
    x = np.linspace(0.0, 1500.0, 61)
    points = "\n".join(f"B,{a},{b}" for a, b in zip(x, height(x), strict=True))
    stops = (1350, 1300, 1400, 1450, 1250, 1380)
    rows = [f"e{k},B,19{50 + k},{stop},,{2000 * (k + 1)}" for k, stop in enumerate(stops)]
    rows += ["gone,B,1990,,1,90000", "unknown,B,,1330,,"]
    header = "event_id,path_id,date,runout_x_m,left_profile,volume_m3"
    import_files(
        database,
        [
            write("paths.csv", "path_id,observed_from,observed_to\nB,1940,2000\n"),
            write("profiles.csv", f"path_id,x_m,y_m\n{points}\n"),
            write("events.csv", "\n".join([header, *rows]) + "\n"),
        ],
    )
    calibrate(database, "b", CalibrateRequest(chains=2, draws=100))
    hazard(database, "b", HazardRequest(volumes=[1e3, 5e5], draws=500))
    content = gather(database, "b", ReportRequest())
    (view,) = content.paths
    gone = next(e for e in view.events if e.event_id == "gone")
    assert (gone.left_profile, gone.stop_x_m, gone.observed_m) == (True, None, None)
    assert any(row.runout_x_m.q95 is None for row in view.rows)
    text = render(content)
    assert "beyond" in text
    assert 'id="figure-predicted-x"' in text


def test_changed_records_are_said(copied: str, write: Write) -> None:
    import_files(
        copied,
        [write("more.csv", "event_id,path_id,date,runout_elevation_m\nnew,scey,1999,1200\n")],
    )
    content = gather(copied, "m", ReportRequest())
    assert content.records_changed
    assert len(content.events) == 62


@pytest.mark.parametrize("name", ["report.txt", "report", "none/report.html"])
def test_a_file_that_cannot_be_is_refused(report_database: str, tmp_path: Path, name: str) -> None:
    with pytest.raises(AvahazardError):
        write_report(report_database, "m", tmp_path / name, ReportRequest())
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_its_place_is_one_message(report_database: str, tmp_path: Path) -> None:
    (tmp_path / "report.html").mkdir()
    with pytest.raises(AvahazardError, match="cannot be written"):
        write_report(report_database, "m", tmp_path / "report.html", ReportRequest())
    assert os.listdir(tmp_path) == ["report.html"]


def test_an_unknown_model_is_one_message(report_database: str, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no model nobody"):
        write_report(report_database, "nobody", tmp_path / "r.html", ReportRequest())
