"""`avahazard demo`: run once, from nothing, and looked at from all sides."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from avahazard.cli.main import app
from avahazard.cli.output import show
from avahazard.cli.project import show_demo, show_loop
from avahazard.report.language import TERMINAL, speaking
from avahazard.results.base import Rows
from avahazard.results.files import Demo
from avahazard.store.upkeep import status
from avahazard.workflow import demo
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.hazard import hazard
from avahazard.workflow.requests import CalibrateRequest, HazardRequest
from tests.few_draws import few_draws
from tests.report.html.chromium import Seen, chromium
from tests.telling import untold
from tests.workflow.twin import TRUTH


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any, str]:
    """Give the folder that the command was run in, its document and its progress.

    With fewer draws, and a smaller dataset, than people get; `tests/workflow/test_demo.py` runs all
    of it.
    """
    folder = tmp_path_factory.mktemp("a")
    with pytest.MonkeyPatch.context() as patch, few_draws():
        patch.chdir(folder)
        patch.setattr(demo, "hazard", hazard_with_fewer_draws)
        patch.setattr(demo, "N_EVENTS", 60)
        patch.setattr(demo, "N_PATHS", 3)
        patch.setattr(demo, "calibrate", with_fewer_draws)
        done = CliRunner().invoke(app, ["--json", "demo"])
    assert done.exit_code == 0, done.output
    return folder, json.loads(done.stdout), done.stderr


def with_fewer_draws(database: str, name: str, asked: CalibrateRequest, *more: Any) -> Any:
    """A calibration in two chains of what is needed to converge."""
    return calibrate(database, name, replace(asked, chains=2, draws=500), *more)


def hazard_with_fewer_draws(database: str, name: str, asked: HazardRequest, *more: Any) -> Any:
    """Runouts by draws that are enough to see them."""
    return hazard(database, name, replace(asked, draws=400), *more)


@pytest.fixture(scope="module")
def found(run: tuple[Path, Any, str]) -> Demo:
    """Give what it found."""
    return Demo.from_dict(run[1])


@speaking(TERMINAL)
def printed(found: Demo, capsys: pytest.CaptureFixture[str]) -> str:
    show(Console(width=80, markup=False, highlight=False), show_demo(found))
    return capsys.readouterr().out


@speaking(TERMINAL)
def loop_words(found: Demo, capsys: pytest.CaptureFixture[str]) -> str:
    show(Console(width=80, markup=False, highlight=False), show_loop(found.loop))
    return capsys.readouterr().out


def test_what_it_leaves(run: tuple[Path, Any, str], found: Demo) -> None:
    folder = run[0]
    for file in (*found.files, *found.loop.files):
        assert (folder / file).stat().st_size > 0
    assert {file.name for file in folder.iterdir()} == {"avahazard-demo"}
    counts = status(str(folder / found.database)).counts
    assert (counts["events"], counts["models"]) == (173, 2)


def test_the_twins_bounds_and_truth(found: Demo) -> None:
    assert len(found.hazard) == 7
    assert all(row.design.runout_x_m.q50 is not None for row in found.hazard)
    for model in (found.model, found.gibbs):
        assert model.diagnostics.converged
        for name, value in TRUTH.items():
            parameter = model.parameters[name]
            assert parameter.q05 < value < parameter.q95, (model.model, name)


def test_what_was_hidden_is_named_added_and_the_error_falls(found: Demo) -> None:
    loop = found.loop
    assert loop.model.effects == ()
    assert loop.diagnosis.verdict == "missing-effect"
    assert loop.diagnosis.missing == tuple(loop.hidden)
    assert loop.child is not None
    assert loop.child.effects == loop.diagnosis.missing
    assert loop.child.diagnostics.converged
    compared = loop.child.comparison
    assert compared is not None
    assert compared.before is not None
    assert compared.before.held_out_crps_m == loop.held_out.runout.crps_m
    assert compared.after.held_out_crps_m < compared.before.held_out_crps_m
    assert compared.fall is not None
    assert compared.fall.q05_m < compared.fall.mean_m < compared.fall.q95_m


def test_progress_is_one_and_never_goes_back(run: tuple[Path, Any, str]) -> None:
    shares = [int(share) for share in re.findall(r"^.+: (\d+)%", run[2], re.MULTILINE)]
    assert shares
    assert shares == sorted(shares)


@pytest.mark.parametrize(
    ("which", "width"),
    [
        # `tests/report/html` looks at a report of the same makers in the same way.
        pytest.param("hidden-report.html", 1400, marks=pytest.mark.slow),
        pytest.param("hidden-report.html", 390, marks=pytest.mark.slow),
        pytest.param("twin-report.html", 1400, marks=pytest.mark.slow),
        pytest.param("twin-report.html", 390, marks=pytest.mark.slow),
    ],
)
def test_its_reports_in_a_browser(run: tuple[Path, Any, str], which: str, width: int) -> None:
    report = run[0] / "avahazard-demo" / which
    assert report.stat().st_size < 10e6
    with chromium() as browser:
        seen = Seen(browser, report, width)
        assert seen.said == []
        assert seen.asked == [report.as_uri()]
        assert seen.overflow() <= 0
        assert seen.blank() == []
        assert unescape(seen.point_at_an_event()) in seen.hovered()


def test_people_see_both_parts_and_the_files(
    found: Demo, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(found, capsys)
    assert untold(text, "twin", "Ancey (2005)", *found.loop.hidden, found.loop.report) == []
    assert found.database in text
    assert text.split("One file to open")[1].split()[4] == found.loop.report


def test_the_words_are_of_what_came_out(found: Demo, capsys: pytest.CaptureFixture[str]) -> None:
    loop = found.loop
    words = loop_words(found, capsys)
    assert loop.child is not None
    assert loop.child.comparison is not None
    assert loop.child.comparison.before is not None
    errors = (loop.child.comparison.before, loop.child.comparison.after)
    assert untold(words, *(f"{error.held_out_crps_m:.1f}" for error in errors)) == []
    assert "the diagnosis is right" in " ".join(words.split())
    assert max(map(len, words.splitlines())) <= 80

    adequate = replace(loop.diagnosis, verdict="adequate", missing=(), candidates=Rows())
    nothing = loop_words(replace(found, loop=replace(loop, diagnosis=adequate, child=None)), capsys)
    assert "none is added" in " ".join(nothing.split())
    assert "did not find it" in " ".join(nothing.split())
    wrong = loop_words(replace(found, loop=replace(loop, hidden={"forest-drag": {}})), capsys)
    assert "did not find it" in " ".join(wrong.split())
    hidden = next(iter(loop.hidden))
    both = replace(loop.diagnosis, verdict="ambiguous", missing=(hidden, "season"))
    among = loop_words(replace(found, loop=replace(loop, diagnosis=both, child=None)), capsys)
    assert "among what was named" in " ".join(among.split())


def test_a_folder_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "avahazard-demo").write_text("a file")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["demo"])
    assert (done.exit_code, done.stdout) == (1, "")
    assert untold(done.stderr, "avahazard-demo", "--folder") == []
    assert "Traceback" not in done.stderr
