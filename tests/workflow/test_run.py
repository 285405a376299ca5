"""A whole project: done once, then only what is out of date."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.results.files import ProjectRun
from avahazard.store.results import list_models
from avahazard.store.session import reading
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_records
from avahazard.workflow import run as project
from avahazard.workflow.requests import RunRequest
from avahazard.workflow.run import RunningProject, read_project, run_project

pytestmark = pytest.mark.usefixtures("drawn_little")

SMALL = """
files = ["world"]
database = "valley.db"
skip = ["compare", "diagnose", "zones", "report"]
[model]
chains = 2
draws = 100
[hazard]
return_periods = [30, 100]
paths = ["P01"]
[export]
files = ["bounds.csv"]
"""

LIMITS = """
[[zone]]
name = "red"
color = "#c8102e"
[[zone.rule]]
return_period_years = 30
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "world"
    folder.mkdir()
    write_records(folder, make_dataset(3, 36, 3, {"snow-type": 2.0})[0])
    return folder


@pytest.fixture
def folder(world: Path, tmp_path: Path) -> Path:
    shutil.copytree(world, tmp_path / "world")
    (tmp_path / "avahazard.toml").write_text(SMALL)
    return tmp_path


NOW = RunRequest()


def ran(folder: Path, request: RunRequest = NOW) -> ProjectRun:
    return run_project(folder / "avahazard.toml", "not this one.db", request)


def states(found: ProjectRun) -> dict[str, str]:
    return {step.step: step.state for step in found.steps}


def test_a_second_run_does_nothing_and_a_third_what_has_changed(folder: Path) -> None:
    dry = ran(folder, RunRequest(dry_run=True))
    assert set(states(dry).values()) == {"to do"}
    assert not list(folder.glob("valley.db*"))
    first = ran(folder)
    assert list(states(first)) == list(states(dry))
    assert set(states(first)) == {"import", "calibrate base", "hazard", "export"}
    assert set(states(first).values()) == {"done"}
    assert first.model == "base"
    written = (folder / "bounds.csv").read_bytes()
    again = ran(folder)
    assert set(states(again).values()) == {"up to date"}
    # What is said of the model is said again, and once.
    assert "the chains of base have not converged." in again.notes
    assert len(set(first.notes)) == len(first.notes)
    assert not Path("not this one.db").exists()

    # Other bounds of the same model.
    file = folder / "avahazard.toml"
    file.write_text(SMALL.replace("[30, 100]", "[100]"))
    less = ran(folder)
    assert states(less) == states(again) | {"hazard": "done", "export": "done"}
    assert (folder / "bounds.csv").read_bytes() != written

    # All paths, where the last run had one; then others by chance.
    file.write_text(SMALL.replace("[30, 100]", "[100]").replace('paths = ["P01"]\n', ""))
    assert states(ran(folder)) == states(less)
    assert "P02" in (folder / "bounds.csv").read_text()
    assert set(states(ran(folder)).values()) == {"up to date"}
    file.write_text(SMALL.replace("[30, 100]", "[100]").replace("[hazard]", "[hazard]\nseed = 1"))
    assert states(ran(folder)) == states(less)

    # Other records: the model of the old ones is kept.
    events = folder / "world" / "events.csv"
    lines = events.read_text().splitlines()
    events.write_text("\n".join([*lines, lines[-1].replace(lines[-1].split(",")[0], "new", 1)]))
    dry = ran(folder, RunRequest(dry_run=True))
    assert (dry.model, set(states(dry).values())) == ("base-2", {"to do"})
    more = ran(folder)
    assert more.model == "base-2"
    assert set(states(more).values()) == {"done"}
    with reading(str(folder / "valley.db")) as session:
        assert [model.name for model in list_models(session)] == ["base", "base-2"]
    assert set(states(ran(folder, RunRequest(dry_run=True))).values()) == {"up to date"}
    forced = ran(folder, RunRequest(force=True))
    assert forced.model == "base-3"
    assert set(states(forced)) == {"import", "calibrate base-3", "hazard", "export"}


def test_zones_are_found_again_for_other_limits_or_paths(folder: Path) -> None:
    file, limits = folder / "avahazard.toml", folder / "own.toml"
    limits.write_text(LIMITS)
    text = SMALL.replace('"zones", "report"', '"report", "hazard"')
    text += '[zones]\nlimits = "own.toml"\n'
    file.write_text(text)
    without = ran(folder)
    assert states(without)["zones"] == "left out"
    assert any("no_drag = true in [zones]" in note for note in without.notes)
    text += "no_drag = true\n"
    file.write_text(text)
    found = []
    for change in ("", "", "limits", "", "paths", ""):
        if change == "limits":
            limits.write_text(LIMITS.replace("30", "40"))
        elif change == "paths":
            file.write_text(text.replace('paths = ["P01"]', 'paths = ["P02"]'))
        found.append(states(ran(folder))["zones"])
    assert found == ["done", "up to date"] * 3


def test_the_page_is_made_again_for_another_title(folder: Path) -> None:
    file, page = folder / "avahazard.toml", folder / "page.html"
    text = SMALL.replace('"zones", "report"', '"zones", "hazard", "export"')
    text = text.replace("[export]", '[report]\nfile = "page.html"\n[export]')
    file.write_text(text)
    assert states(ran(folder))["report"] == "done"
    assert states(ran(folder))["report"] == "up to date"
    file.write_text(f'{text}[project]\ntitle = "Under the Aiguille"\n')
    assert states(ran(folder))["report"] == "done"
    assert "Under the Aiguille" in page.read_text(encoding="utf-8")


def test_another_prior_is_another_model(folder: Path) -> None:
    """Records of other paths stand for the law of the few of one path."""
    file = folder / "avahazard.toml"
    bare = (
        'files = ["world"]\n'
        'skip = ["compare", "diagnose", "hazard", "zones", "report", "export"]\n'
        '[model]\nchains = 2\ndraws = 100\npaths = ["P01"]\n'
    )
    told = bare + 'prior_from = "fit:P02,P03"\n'
    numbers = bare + "prior = {a = [0.5, 0.05], n = [2e-6, 1e-6]}\n"
    found = []
    for text in (told, told, bare, told, numbers, numbers):
        file.write_text(text)
        run = run_project(file, str(folder / "prior.db"), NOW)
        found.append((run.model, states(run)[f"calibrate {run.model}"]))
    assert found == [
        ("base", "done"), ("base", "up to date"), ("base-2", "done"), ("base", "up to date"),
        ("base-3", "done"), ("base-3", "up to date"),
    ]  # fmt: skip


def test_doubts_about_the_rows_are_told_unless_they_are_meant(tmp_path: Path) -> None:
    (tmp_path / "events.csv").write_text(
        "event_id,fall_height_m,runout_length_m,volume_m3\na,900,1500,5e9\n"
    )
    file = tmp_path / "avahazard.toml"
    told = []
    for more in ("", "unusual = true\n"):
        file.write_text(f'files = ["events.csv"]\n{more}')
        run = RunningProject(read_project(file), tmp_path, str(tmp_path / "a.db"), NOW, print, 0.0)
        run.import_records()
        told.append(run.notes)
    assert "line 2: 5e9" in told[0][0]
    assert told[1] == []


@pytest.mark.slow
def test_what_was_interrupted_goes_on(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def discontinuous(*_given: object, **_named: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(project, "hazard", discontinuous)
        with pytest.raises(KeyboardInterrupt):
            ran(folder)
    found = states(ran(folder))
    assert found["calibrate base"] == "up to date"
    assert found["hazard"] == found["export"] == "done"


@pytest.mark.slow
def test_what_is_named_is_added_and_the_answers_are_by_the_child(folder: Path) -> None:
    (folder / "avahazard.toml").write_text(
        'files = ["world"]\n[diagnose]\nadd = true\n[export]\nfiles = ["bounds.csv"]\n'
    )
    found = run_project(folder / "avahazard.toml", str(folder / "snow.db"), NOW)
    assert found.model == "base+snow-type"
    assert [step.step for step in found.steps] == [
        "import",
        "calibrate base",
        "compare base",
        "diagnose base",
        "add base+snow-type",
        "compare base+snow-type",
        "diagnose base+snow-type",
        "hazard",
        "zones",
        "report",
        "export",
    ]
    assert (folder / "report.html").stat().st_size > 100_000
    again = run_project(folder / "avahazard.toml", str(folder / "snow.db"), NOW)
    # A model without drag has no zones.
    left = {step for step, state in states(again).items() if state != "up to date"}
    assert left <= {"zones"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "files: Field required"),
        ('files = ["world"]\ncolour = 1', "colour: there is no such key (given: 1)"),
        ('files = ["world"]\n[model]\nscatter = "much"', "model, scatter"),
        ('files = ["world"]\n[hazard]\nreturn_periods = [100, 0.5]', "hazard, return_periods 2"),
        ('files = ["world"', "is not a TOML file"),
        ('files = ["world"]\n[report]\nfile = "r.pdf"', "r.pdf is not the name of a page"),
        ('files = ["world"]\n[export]\nfiles = ["x.shp"]', "x.shp does not end in"),
        ('files = ["world"]\n[zones]\nlimits = "german"', "There are no limits 'german'"),
    ],
)
def test_a_file_at_fault_is_refused_with_its_place(folder: Path, text: str, words: str) -> None:
    file = folder / "avahazard.toml"
    file.write_text(text)
    with pytest.raises(AvahazardError) as caught:
        run_project(file, str(folder / "new.db"), NOW)
    assert words in str(caught.value)
    assert not (folder / "new.db").exists()


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="cannot be read: No such file"):
        run_project(tmp_path / "avahazard.toml", str(tmp_path / "new.db"), NOW)


def test_the_page_tells_every_key() -> None:
    from avahazard.workflow.run import Project  # noqa: PLC0415

    page = (Path(__file__).parents[2] / "docs" / "project.md").read_text(encoding="utf-8")
    for name, field in Project.model_fields.items():
        assert f"{name} = " in page or f"[{name}]" in page
        inner = getattr(field.annotation, "model_fields", {})
        for key, one in inner.items():
            assert f"{one.alias or key} = " in page
