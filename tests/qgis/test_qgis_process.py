"""The algorithms run by the real qgis_process."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import missing
from tests.engines.slope import write_slope

ROOT = Path(__file__).resolve().parents[2]
# Debian's wrapper passes on an option that the program does not know.
PROCESS = shutil.which("qgis_process.bin") or shutil.which("qgis_process")

Run = Callable[..., dict[str, Any]]


@pytest.fixture(scope="module")
def algorithm(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Give a function that runs an algorithm of the plugin, which is on."""
    if PROCESS is None:
        missing("qgis_process is not there: apt-get install qgis python3-qgis")
    home = tmp_path_factory.mktemp("qgis")
    plugins = home / ".local/share/QGIS/QGIS3/profiles/default/python/plugins"
    plugins.mkdir(parents=True)
    (plugins / "avahazard_qgis").symlink_to(ROOT / "qgis/avahazard_qgis")
    # Not the environment's Python, which QGIS cannot use: its command alone.
    commands = home / "bin"
    commands.mkdir()
    command = shutil.which("avahazard") or str(ROOT / ".venv/bin/avahazard")
    (commands / "avahazard").symlink_to(command)
    environment = {
        "HOME": str(home),
        "PATH": f"/usr/bin:/bin:{commands}",
        "QT_QPA_PLATFORM": "offscreen",
        "LANG": "C.UTF-8",
    }

    def process(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(PROCESS), *words], env=environment, capture_output=True, text=True, check=False
        )

    # As `qgis_process plugins enable` writes it.
    settings = plugins.parents[1] / "QGIS" / "QGIS3.ini"
    settings.parent.mkdir()
    settings.write_text("[PythonPlugins]\navahazard_qgis=true\n", encoding="utf-8")

    def run(name: str, **parameters: object) -> dict[str, Any]:
        words = [f"{key}={value}" for key, value in parameters.items()]
        found = process("--json", "run", f"avahazard:{name}", "--", *words)
        assert found.returncode == 0, found.stdout + found.stderr
        results: dict[str, Any] = json.loads(found.stdout[found.stdout.index("{") :])["results"]
        return results

    return run


def test_records_are_imported(algorithm: Run, tmp_path: Path) -> None:
    write_slope(tmp_path)
    database = tmp_path / "q.db"
    found = algorithm(
        "import",
        DATABASE=database,
        TABLE=tmp_path / "events.csv",
        LINES=tmp_path / "line.gpkg",
        DEM=tmp_path / "dem.tif",
    )
    assert (found["PATHS"], found["EVENTS"]) == (1, 40)


@pytest.mark.slow
def test_the_other_algorithms(algorithm: Run, tmp_path: Path) -> None:
    write_slope(tmp_path)
    database = tmp_path / "q.db"
    inputs = {"LINES": tmp_path / "line.gpkg", "DEM": tmp_path / "dem.tif"}
    algorithm("import", DATABASE=database, TABLE=tmp_path / "events.csv", **inputs)
    assert "a = " in algorithm("calibrate", DATABASE=database, NAME="base")["PARAMETERS"]
    found = algorithm("diagnose", DATABASE=database, NAME="base")
    assert found["VERDICT"] in ("adequate", "missing-effect", "ambiguous", "unexplained")
    layers = tmp_path / "layers.gpkg"
    assert algorithm("hazard", DATABASE=database, NAME="base", PERIODS="30,100", OUTPUT=layers)
    assert layers.stat().st_size > 0
    for name, file in (("map", "map.tif"), ("map", "map.gpkg"), ("report", "report.html")):
        algorithm(name, DATABASE=database, NAME="base", OUTPUT=tmp_path / file)
        assert (tmp_path / file).stat().st_size > 0
