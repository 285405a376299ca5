"""The tutorials: their commands run, and their texts agree with the outputs."""

from __future__ import annotations

import re
import shlex
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

from avahazard.cli.main import app
from avahazard.hazard.frequency import ReturnVolumeRow, read_return_volumes
from avahazard.records.rows import EventRow, PathRow, ProfileRow, StraightRow, VelocityRow

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = sorted((DOCS / "tutorial").glob("*.md"))
KILOBYTES = 150

# The same commands on less: enough to see that they work; `make test-slow` runs the real ones.
SMALLER = {
    # Two paths with forest.
    "--events 100 --paths 6 --seed 3": "--events 20 --paths 2 --seed 2",
    "--events 80 --paths 4": "--events 24 --paths 2",
    "avahazard calibrate base": "avahazard calibrate base --chains 2 --draws 60",
    "local --with turbulent-drag": "local --chains 2 --draws 60",
    "zones local": "zones local --no-drag",
    'law="exponential"': "chains=2, draws=60",
}
# The same commands again, on another model.
AGAIN = ("avahazard diagnose forest", "avahazard add forest season")


def load_tutorials() -> ModuleType:
    """The script that runs the pages."""
    spec = spec_from_file_location("tutorials", DOCS / "_tools" / "tutorials.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["tutorials"] = module
    spec.loader.exec_module(module)
    return module


tutorials = load_tutorials()


def outputs(page: str) -> str:
    """All that the commands of a page printed."""
    return "".join(b.text for b in tutorials.blocks(page) if b.language == "text")


def smaller(commands: str) -> str:
    """The same commands on less."""
    for old, new in SMALLER.items():
        commands = commands.replace(old, new)
    return commands


def verdicts(printed: str) -> list[str]:
    """The lines that a reader takes away: what is missing, and how the error changed."""
    words = ("lacks an effect", "is adequate", "held-out CRPS falls", "fails along")
    return [line for line in printed.splitlines() if any(word in line for word in words)]


def words_and_numbers(line: str) -> tuple[str, list[float]]:
    """A line without its numbers, and the numbers."""
    number = r"[+-]?\d+(?:\.\d+)?"
    return re.sub(number, "#", line), [float(v) for v in re.findall(number, line)]


@pytest.mark.parametrize("file", PAGES, ids=lambda file: file.stem)
def test_figures_in_the_text_are_in_the_outputs(file: Path) -> None:
    page = file.read_text(encoding="utf-8")
    claimed = re.findall(r"\*\*([\d.]+)\*\*", page)
    printed = set(re.findall(r"\d+(?:\.\d+)?", outputs(page)))
    assert claimed
    assert [number for number in claimed if number not in printed] == []


@pytest.mark.parametrize("file", PAGES, ids=lambda file: file.stem)
def test_pictures_are_there_and_small(file: Path) -> None:
    shown = tutorials.pictures(file.read_text(encoding="utf-8"))
    assert all((file.parent / name).stat().st_size < KILOBYTES * 1000 for name in shown)


def test_no_picture_is_left_over() -> None:
    shown = {n for file in PAGES for n in tutorials.pictures(file.read_text(encoding="utf-8"))}
    assert {file.name for file in (DOCS / "tutorial").glob("*.png")} == shown


@pytest.mark.usefixtures("drawn_little")
@pytest.mark.parametrize("file", PAGES, ids=lambda file: file.stem)
def test_every_command_runs(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("AVAHAZARD_DB", raising=False)
    runner = CliRunner()
    page = file.read_text(encoding="utf-8")
    names: dict[str, object] = {}
    for block in tutorials.blocks(page):
        if block.title is not None:
            (tmp_path / block.title).write_text(block.text, encoding="utf-8")
        if block.language == "python":
            tutorials.run_cell(smaller(block.text), names, tmp_path)
        if block.language != "sh":
            continue
        for line in smaller(block.text).splitlines():
            if line.startswith(AGAIN):
                continue
            words = shlex.split(line)
            if words[:1] == ["avahazard"]:
                done = runner.invoke(app, words[1:])
                assert done.exit_code == 0, f"{line}\n{done.output}\n{done.exception!r}"
            else:
                tutorials.run_commands(line, tmp_path)
    assert all((tmp_path / name).exists() for name in tutorials.pictures(page))


@pytest.mark.slow
@pytest.mark.parametrize("file", PAGES, ids=lambda file: file.stem)
def test_the_page_says_what_comes_out(file: Path, tmp_path: Path) -> None:
    page = file.read_text(encoding="utf-8")
    found = tutorials.run_page(page, tmp_path)
    lines = list(zip(verdicts(outputs(page)), verdicts(outputs(found)), strict=True))
    for said, new in lines:
        (words, numbers), (new_words, new_numbers) = words_and_numbers(said), words_and_numbers(new)
        assert words == new_words
        # Another machine rounds otherwise, and chains then part.
        assert new_numbers == pytest.approx(numbers, rel=0.1, abs=2.0)


def test_the_forms_examples_are_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = (DOCS / "data_forms.md").read_text(encoding="utf-8")
    files = {b.title: b.text for b in tutorials.blocks(page) if b.title is not None}
    folder = tmp_path / "records"
    folder.mkdir()
    for title, text in files.items():
        place = tmp_path if title.startswith("own_") else folder
        (place / title).write_text(text, encoding="utf-8")
    runner = CliRunner()
    assert runner.invoke(app, ["init"]).exit_code == 0
    done = runner.invoke(app, ["import", "records"])
    assert done.exit_code == 0, done.output
    assert len(files) == 5 + 1
    assert read_return_volumes(tmp_path / "own_volumes.csv").keys() == {"north"}


def test_every_column_of_the_forms_is_on_the_page() -> None:

    page = (DOCS / "data_forms.md").read_text(encoding="utf-8")
    forms = (PathRow, ProfileRow, EventRow, StraightRow, VelocityRow, ReturnVolumeRow)
    columns = {name for form in forms for name in form.model_fields}
    assert {name for name in columns if f"`{name}`" not in page} == set()
