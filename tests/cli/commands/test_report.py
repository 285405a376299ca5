"""`avahazard report`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from tests.telling import untold

pytestmark = pytest.mark.usefixtures("drawn_little")

Run = Callable[..., Result]


def test_the_document(
    on_models: Run, on_my_models: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    document = json.loads(
        on_models(
            "--json", "report", "base", "-o", "m.html", "--language", "de", "--date", "2026-11-22"
        ).stdout
    )
    assert document["file"] == "m.html"
    assert (tmp_path / "m.html").stat().st_size == document["bytes"]
    page = (tmp_path / "m.html").read_text(encoding="utf-8")
    assert '<html lang="de">' in page
    assert "22.11.2026" in page
    # What the command says is English, whatever the page is in.
    advice = ("Make them: ", "Do it: ", "To accept them: ")
    assert all(any(words in note for words in advice) for note in document["lacking"])
    command = next(note for note in document["lacking"] if " zones " in note).rpartition(": ")[2]
    assert on_my_models(*command.split()[1:], "--path", "scey").exit_code == 0


def test_a_wrong_ending_is_one_message(on_models: Run, tmp_path: Path) -> None:
    done = on_models("report", "base", "-o", str(tmp_path / "m.pdf"))
    assert (done.exit_code, done.stdout) == (1, "")
    assert untold(done.stderr, "must end in .html") == []
    assert list(tmp_path.iterdir()) == []


def test_only_known_languages_are_taken(on_models: Run) -> None:
    done = on_models("report", "base", "-o", "m.html", "--language", "es")
    assert done.exit_code == 2
    assert "'es'" in done.stderr


def test_the_file_has_to_be_named(on_models: Run) -> None:
    assert on_models("report", "base").exit_code == 2
