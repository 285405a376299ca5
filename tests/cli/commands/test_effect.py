"""`avahazard effect`."""

from __future__ import annotations

from pathlib import Path

from tests.cli.commands.snow import document, refused, run


def test_one_effect(snow_database: str) -> None:
    found = document(snow_database, "effect", "turbulent-drag")
    assert found["key"] == "turbulent-drag"
    assert found["parameters"][0]["unit"] == "1/m"
    text = run(snow_database, "effect", "turbulent-drag").stdout
    assert "Voellmy" in text
    assert "0 to 0.03" in text
    assert "These data support it." in text


def test_a_template(snow_database: str, tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    done = run(snow_database, "effect", "new", str(file))
    assert done.exit_code == 0
    assert str(file) in done.stdout
    assert "def friction(columns)" in file.read_text(encoding="utf-8")
    assert "not overwritten" in refused(snow_database, "effect", "new", str(file))


def test_bad_input(snow_database: str, tmp_path: Path) -> None:
    assert "There is no effect 'magic'" in refused(snow_database, "effect", "magic")
    assert "Did you mean forest-drag?" in refused(snow_database, "effect", "forestdrag")
    assert "new FILE" in refused(snow_database, "effect", "new", status=2)
    refused(snow_database, "effect", "season", str(tmp_path / "own.py"), status=2)
    said = refused(snow_database, "effect", "new", str(tmp_path / "no" / "folder" / "own.py"))
    assert "own.py" in said
