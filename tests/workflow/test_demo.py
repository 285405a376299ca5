"""The main job on the twin, from nothing."""

from __future__ import annotations

from html import unescape
from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.results.made import Demo
from avahazard.store.upkeep import status
from avahazard.workflow.demo import run_demo
from tests.report.html.chromium import Seen, chromium
from tests.workflow.twin import TRUTH


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Demo, Demo]:
    """Give what two demos into one folder say."""
    folder = tmp_path_factory.mktemp("a") / "demo"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    return run_demo(folder), run_demo(folder)


def test_twice_into_one_folder(runs: tuple[Demo, Demo]) -> None:
    first, again = runs
    assert (Path(first.database).parent / "notes.txt").read_text() == "mine"
    for file in first.files:
        assert Path(file).stat().st_size > 0
    assert again.hazard == first.hazard
    assert len(first.hazard) == 7
    assert all(None not in row.runout_x_m.to_dict().values() for row in first.hazard)
    counts = status(first.database).counts
    assert (counts["events"], counts["models"]) == (173, 2)
    for model in (first.model, first.gibbs):
        assert model.diagnostics.converged
        for name, value in TRUTH.items():
            found = model.parameters[name]
            assert found.q05 < value < found.q95, (model.model, name)


def test_its_report_in_a_browser(runs: tuple[Demo, Demo]) -> None:
    (report,) = (Path(file) for file in runs[1].files if file.endswith(".html"))
    assert report.stat().st_size < 10e6
    with chromium() as browser:
        for width in (390, 1400):
            seen = Seen(browser, report, width)
            assert seen.said == []
            assert seen.asked == [report.as_uri()]
            assert seen.overflow() <= 0
            assert seen.blank() == []
        assert unescape(seen.point_at_an_event()) in seen.hovered()
        assert seen.page.pdf().startswith(b"%PDF")


def test_a_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "demo").write_text("a file")
    with pytest.raises(AvahazardError, match="cannot be used") as caught:
        run_demo(tmp_path / "demo")
    assert "--folder" in caught.value.hint
