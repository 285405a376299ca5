"""`avahazard synth`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from typer.testing import Result

Run = Callable[..., Result]


def test_synth_makes_a_world_that_imports(avahazard: Run, tmp_path: Path) -> None:
    folder = tmp_path / "world"
    made = avahazard(
        "synth",
        str(folder),
        "--effect",
        "snow-type",
        "--events",
        "50",
        "--paths",
        "3",
        "--seed",
        "4",
    )
    assert made.exit_code == 0
    assert "Hidden effects: snow-type." in made.stdout
    assert avahazard("import", str(folder)).exit_code == 0


def test_synth_json_is_one_document(avahazard: Run, tmp_path: Path) -> None:
    made = avahazard("--json", "synth", str(tmp_path / "w"), "--events", "30", "--speeds", "0.5")
    document = json.loads(made.stdout)
    assert document["n_events"] == 30
    assert document["n_speeds"] > 50
    assert all(Path(file).is_file() for file in document["files"])


def test_synth_refuses_what_it_cannot_do(avahazard: Run, tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").write_text("", encoding="utf-8")
    full = avahazard("synth", str(tmp_path / "full"))
    assert full.exit_code == 1
    assert "not an empty folder" in full.stderr
    unknown = avahazard("synth", str(tmp_path / "w"), "--effect", "gravity")
    assert unknown.exit_code == 1
    assert "turbulent-drag" in unknown.stderr
    assert avahazard("synth", str(tmp_path / "w"), "--events", "0").exit_code == 2
