"""`avahazard export`, and `import` of lines, through the command."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pyogrio
import pytest
from typer.testing import Result

from avahazard.store.results import BOUNDS
from avahazard.store.session import writing
from tests.gis.results import bounds_row
from tests.gis.surface import BOTTOM, TOP, write_dem, write_lines
from tests.store.documents import save_bare, save_documents

Run = Callable[..., Result]


@pytest.fixture
def lines(tmp_path: Path) -> Path:
    """Give a file with one good line and its terrain model `dem.asc`."""
    write_dem(tmp_path / "dem.asc")
    return write_lines(tmp_path / "lines.shp", [[TOP, BOTTOM]], {"path_id": ["P"]})


def test_from_a_line_to_a_map(avahazard: Run, database: str, lines: Path, tmp_path: Path) -> None:
    dem = str(tmp_path / "dem.asc")
    done = avahazard("--json", "import", str(lines), "--dem", dem)
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["records"]["profiles"]["new"] == 1
    with writing(database) as session:
        save_bare(session, "base")
        save_documents(session, BOUNDS, "base", [bounds_row().to_dict()])
    file = tmp_path / "map.gpkg"
    done = avahazard("export", "base", "-o", str(file))
    assert done.exit_code == 0, done.output
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "runouts" in done.stdout
    assert "no zones are stored by base" in done.stderr
    names = {str(name) for name, _ in pyogrio.list_layers(file)}
    assert {"design_runouts", "volume_runouts"} <= names
    document = json.loads(avahazard("--json", "export", "base", "-o", str(file)).stdout)
    assert document["layers"][0] == {"layer": "paths", "n_features": 1, "crs": "EPSG:31287"}


def test_a_line_drawn_uphill(avahazard: Run, tmp_path: Path, lines: Path) -> None:
    up = write_lines(tmp_path / "up.gpkg", [[BOTTOM, TOP]], {"name": ["P"]})
    done = avahazard("import", str(up), "--dem", str(tmp_path / "dem.asc"))
    assert (done.exit_code, done.stdout) == (1, "")
    shown = " ".join(done.stderr.split())
    assert "up.gpkg" in shown
    assert "1 geometry starts at" in shown
    assert "nothing was imported" in shown
    done = avahazard("import", str(lines))
    assert done.exit_code == 1
    assert "--dem" in done.stderr


def test_export_without_bounds(avahazard: Run, tmp_path: Path) -> None:
    done = avahazard("export", "nobody", "-o", str(tmp_path / "map.gpkg"))
    assert (done.exit_code, done.stdout) == (1, "")
    assert "no model nobody" in done.stderr
