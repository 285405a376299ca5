"""The plugin of QGIS: words of commands, progress, failure and cancellation; no QGIS is needed."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "qgis"))

from avahazard_qgis import command  # noqa: E402


def script(folder: Path, text: str) -> list[str]:
    file = folder / "script.py"
    file.write_text(text)
    return [sys.executable, str(file)]


def test_the_words_of_commands() -> None:
    assert command.import_words(["a", "b.gpkg"], "dem.tif", True) == [
        "import", "a", "b.gpkg", "--dem", "dem.tif", "--update",
    ]  # fmt: skip
    assert command.import_words(["a"], "", False) == ["import", "a"]
    assert command.calibrate_words("m", "turbulent-drag, snow-type", "com1dfa") == [
        "calibrate", "m", "--with", "turbulent-drag", "--with", "snow-type", "--forward", "com1dfa",
    ]  # fmt: skip
    assert command.hazard_words("m", "30, 100") == ["hazard", "m", "-T", "30", "-T", "100"]
    assert command.words_of("avahazard", "a.db", ["init"]) == [
        "avahazard", "--db", "a.db", "--json", "init",
    ]  # fmt: skip


def test_progress_is_read_off_standard_error() -> None:
    assert command.progress_of("Calibrating base: 33%, 28 s left") == ("Calibrating base", 33)
    assert command.progress_of("Note: 33 events") is None


def test_a_command_that_is_not_there_is_told() -> None:
    with pytest.raises(command.CommandError, match="not found"):
        command.find_command("no-such-command")


def test_the_document_the_progress_and_the_messages(tmp_path: Path) -> None:
    words = script(
        tmp_path,
        "import sys\nprint('Work: 50%', file=sys.stderr)\nprint('Note: so', file=sys.stderr)\n"
        "print('{\"ü\": 1}')\n",
    )
    told: list[str] = []
    shares: list[tuple[str, int]] = []
    found = command.run(words, told.append, lambda *share: shares.append(share))
    assert found == {"ü": 1}
    assert told == ["Note: so"]
    assert shares == [("Work", 50)]


def test_a_failure_is_what_the_command_said(tmp_path: Path) -> None:
    words = script(
        tmp_path, "import sys\nsys.stderr.write('Error: no.\\nHint: yes.\\n')\nsys.exit(1)\n"
    )
    with pytest.raises(command.CommandError, match=r"Error: no\.\nHint: yes\."):
        command.run(words)


def test_a_cancelled_command_is_killed(tmp_path: Path) -> None:
    mark = tmp_path / "done"
    words = script(tmp_path, f"import time\ntime.sleep(5)\nopen({str(mark)!r}, 'w').close()\n")
    began = time.monotonic()
    assert command.run(words, cancelled=lambda: time.monotonic() - began > 0.5) is None
    assert not mark.exists()
