"""`avahazard path`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from tests.telling import untold

Run = Callable[..., Result]


def test_the_document(document: Callable[..., Any]) -> None:
    found = document("path", "scey")
    assert found["fit"].keys() >= {"method", "smoothing", "max_deviation_m", "rms_m"}
    assert (found["path_id"], found["fit"]["sigma_from"]) == ("scey", "estimated")
    assert found["fit"]["polynomial_rms_m"] > 1.0 > found["fit"]["max_deviation_m"]
    assert found["drop_m"] == pytest.approx(1090.0, abs=1.0)
    assert found["monotone"] is True


def test_people_see_a_table_with_the_error_and_the_misfits(
    avahazard: Run, write: Callable[[str, str], Path]
) -> None:
    # A cliff of 100 m, which no polynomial of degree 8 follows.
    rows = [f"cliff,{x},{3000 - 0.5 * x - (100 if x >= 1000 else 0)}" for x in range(0, 2001, 20)]
    write("paths.csv", "path_id\ncliff\n")
    points = write("profiles.csv", "path_id,x_m,y_m\n" + "\n".join(rows) + "\n")
    assert avahazard("import", str(points.parent)).exit_code == 0
    done = avahazard("path", "cliff")
    assert done.exit_code == 0
    assert "smoothing spline" in done.stdout
    assert "error of a point, estimated m" in done.stdout
    assert "misfit of the polynomial (rms) m" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_a_picture_is_written(on_twin: Run, tmp_path: Path) -> None:
    file = tmp_path / "path.png"
    assert on_twin("path", "scey", "--plot", str(file)).exit_code == 0
    assert file.read_bytes()[:4] == b"\x89PNG"


def test_what_cannot_be_shown(on_twin: Run, tmp_path: Path) -> None:
    unknown = on_twin("path", "everest")
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    assert untold(unknown.stderr, "'everest'") == []
    assert "saint-clement" in unknown.stderr
    picture = on_twin("path", "scey", "--plot", str(tmp_path / "path.doc"))
    assert picture.exit_code == 1
    assert ".png" in picture.stderr
    assert on_twin("path").exit_code == 2
