"""From an office's spreadsheet to a brief, as a new user goes: by what each command says next."""

from __future__ import annotations

import csv
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from openpyxl import Workbook
from typer.testing import Result

pytestmark = pytest.mark.usefixtures("drawn_little")

MOST_COMMANDS = 12
NEXT = re.compile(r"^  avahazard (?:--db \S+ )?(.+)$", re.MULTILINE)
KINDS = {"dry": "trocken", "wet": "nass", "mixed": "gemischt"}


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def of_office(made: Path, folder: Path) -> tuple[str, str]:
    """A cadastre with a title, German names, ranges and marks, and profiles with decimal commas."""
    sheet = Workbook()
    page = sheet.active
    assert page is not None
    page.append(["Lawinenkataster, Stand 2020"])
    page.append([])
    page.append(["Nr", "Lawinenzug", "Datum", "Auslaufhöhe (m)", "Volumen (m³)", "Schnee"])
    for k, row in enumerate(rows_of(made / "events.csv")):
        if not row["runout_elevation_m"]:
            continue
        volume = float(row["volume_m3"])
        given = f"{0.8 * volume:.0f}-{1.25 * volume:.0f}" if k % 9 == 4 else f"{volume:.0f}"
        date = ".".join(reversed(row["date"].split("-")))
        stop = row["runout_elevation_m"].replace(".", ",")
        kind = KINDS[row["snow_type"]]
        number, path = row["event_id"], row["path_id"]
        page.append([number, path, date, stop, "?" if k % 11 == 5 else given, kind])
    cadastre, profiles = folder / "Kataster.xlsx", folder / "Profile.csv"
    sheet.save(cadastre)
    lines = ["Lawinenzug;Distanz (m);Höhe (m)"]
    for row in rows_of(made / "profiles.csv"):
        lines.append(f"{row['path_id']};{row['x_m']};{row['y_m']}".replace(".", ","))
    profiles.write_text("\n".join(lines), encoding="cp1252")
    return str(profiles), str(cadastre)


def test_from_a_spreadsheet_to_a_brief(
    avahazard: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "made"
    words = ("--events", "36", "--paths", "3", "--seed", "1", "--effect", "snow-type")
    words += ("--strength", "2")
    assert avahazard("synth", str(made), *words).exit_code == 0
    files = of_office(made, tmp_path)
    steps = [("init",), ("import", *files, "--guess-columns"), ("import", *files)]
    done: list[tuple[str, ...]] = []
    while steps:
        step = steps.pop(0)
        result = avahazard(*step)
        assert result.exit_code == 0, f"{step}\n{result.output}"
        done.append(step)
        assert len(done) <= MOST_COMMANDS, done
        if step == ("import", *files, "--guess-columns"):
            correct(tmp_path / "columns.toml")
        elif step == ("import", *files):
            steps = [("calibrate", "base", "--chains", "2", "--draws", "200")]
        elif step[0] not in ("init", "report"):
            found = NEXT.findall(result.stdout)
            assert found, (step, result.stdout)
            steps = [tuple(shlex.split(found[-1]))]
    assert done[-1][0] == "report", done
    (file,) = (word for word in done[-1] if word.endswith(".html"))
    assert "P01" in Path(file).read_text(encoding="utf-8")
    assert ("add", "base", "snow-type") in [step[:3] for step in done]


def correct(mapping: Path) -> None:
    """What the user corrects by hand: a column without a known name."""
    text = mapping.read_text(encoding="utf-8")
    assert '{from = "Volumen (m³)", unit = "m³", range = "geometric"}' in text
    mapping.write_text(text + '\nsnow_type = "Schnee"\n', encoding="utf-8")
