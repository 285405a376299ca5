"""`avahazard paper-figures`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from tests.docs.test_paper_pages import STEMS
from tests.telling import untold

Run = Callable[..., Result]


def test_every_figure_of_the_paper(on_models: Run, tmp_path: Path) -> None:
    """Laws, densities and the posterior with normals, residuals, F and F′, models overlaid."""
    folder = tmp_path / "figures"
    words = ("paper-figures", "base", "--path", "scey", "--folder", str(folder), "--format", "svg")
    rows = json.loads(on_models("--json", *words).stdout)
    # The numbers and files of docs/paper_figures.md.
    assert [row["figure"] for row in rows] == ["1", "2", "3", "F", "4, 6a-c", "6d", "5, 7"]
    assert [row["model"] for row in rows] == [*[None] * 4, "base", "base", None]
    named = {name.replace("NAME", "base").replace("PATH", "scey") for name in STEMS}
    assert {Path(row["file"]).stem for row in rows} == named
    drawn = [Path(row["file"]).read_text(encoding="utf-8") for row in rows]
    # Curves, histograms, points: not empty axes.
    assert all(text.count("<path") > 40 for text in drawn)
    assert sorted(folder.iterdir()) == sorted(Path(row["file"]) for row in rows)


@pytest.mark.slow
def test_models_of_several_methods_at_once(on_models: Run, tmp_path: Path) -> None:
    folder = tmp_path / "figures"
    rows = json.loads(
        on_models("--json", "paper-figures", "base", "plain", "--folder", str(folder)).stdout
    )
    assert len(rows) == 3 + 7 + 2 * 2 + 1
    assert all(Path(row["file"]).stat().st_size > 10_000 for row in rows)


def test_without_a_model_and_what_cannot_be_drawn_says_why(
    avahazard: Run, write: Callable[[str, str], Path], tmp_path: Path
) -> None:
    head = "event_id,fall_height_m,runout_length_m\n"
    lengths = "".join(f"e{k},500,{900 + 40 * k}\n" for k in range(8))
    avahazard("import", str(write("events.csv", head + lengths)))
    done = avahazard("paper-figures", "--folder", str(tmp_path / "figures"))
    assert done.exit_code == 0, done.stderr
    assert [file.name for file in (tmp_path / "figures").iterdir()] == ["2-friction.png"]
    assert untold(done.stderr, "No figure 1", "No figure 3", "there are none") == []
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_nothing_is_left_where_it_cannot_be(on_twin: Run, tmp_path: Path) -> None:
    folder = tmp_path / "figures"
    unknown = on_twin("paper-figures", "nothing", "--folder", str(folder))
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    assert untold(unknown.stderr, "model nothing") == []
    assert not folder.exists()
    folder.write_text("a file", encoding="utf-8")
    assert on_twin("paper-figures", "--folder", str(folder)).exit_code == 1
    assert on_twin("paper-figures", "--format", "gif").exit_code == 2
