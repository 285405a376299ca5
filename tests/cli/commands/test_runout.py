"""`avahazard runout`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

from tests.telling import untold

Run = Callable[..., Result]


def test_the_document(document: Callable[..., Any]) -> None:
    found = document("runout", "scey", "--mu", "0.45")
    assert (found["path_id"], found["mu"], found["status"]) == ("scey", 0.45, "stopped")
    assert 960.0 < found["runout_elevation_m"] < 1500.0
    places = found["speeds"]
    assert places[-1] == {"x_m": found["runout_x_m"], "speed_m_s": 0.0}
    fastest = max(place["speed_m_s"] for place in places)
    assert fastest <= found["speed_max_m_s"] < 1.02 * fastest


def test_people_see_the_stop_and_some_speeds(on_twin: Run) -> None:
    done = on_twin("runout", "scey", "--mu", "0.45")
    assert done.exit_code == 0
    assert "stops at" in done.stdout
    assert len(done.stdout.splitlines()) < 20
    assert "runs beyond the profile" in on_twin("runout", "scey", "--mu", "0.2").stdout
    held = on_twin("--json", "runout", "scey", "--mu", "3")
    assert '"status": "not_released"' in held.stdout
    assert "does not move" in on_twin("runout", "scey", "--mu", "3").stdout


@pytest.mark.parametrize("mu", ["0", "-0.3", "nan", "inf", "steep"])
def test_a_friction_that_is_none(on_twin: Run, mu: str) -> None:
    done = on_twin("runout", "scey", "--mu", mu)
    assert (done.exit_code, done.stdout) == (2, "")
    assert "friction is" in done.stderr or "--mu" in done.stderr


def test_what_cannot_be_run(on_twin: Run) -> None:
    unknown = on_twin("runout", "everest", "--mu", "0.4")
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    assert untold(unknown.stderr, "'everest'") == []
    volume = on_twin("runout", "scey", "--mu", "0.4", "--volume", "5000")
    assert volume.exit_code == 2
    assert "model" in volume.stderr
    assert on_twin("runout", "scey").exit_code == 2


def test_a_model_gives_the_friction_of_a_volume(on_models: Run) -> None:
    words = ("runout", "scey", "--model", "base", "--volume", "20000")
    document = json.loads(on_models("--json", *words).stdout)
    assert document["mu"] == pytest.approx(0.519 * np.exp(-3.36e-7 * 2e4), abs=0.03)
    assert (document["model"], document["mu_from"]) == ("base", "posterior median")
    assert "(posterior median, base)" in on_models(*words).stdout
    given = on_models("runout", "scey", "--model", "base", "--mu", "0.45")
    assert "μ = 0.45 (given, base)" in given.stdout


def test_a_model_needs_a_volume_or_a_friction(on_models: Run) -> None:
    assert on_models("runout", "scey", "--model", "base").exit_code == 2
    assert on_models("runout", "scey", "--model", "base", "--volume", "0").exit_code == 2
    done = on_models("runout", "scey", "--model", "nothing", "--volume", "1000")
    assert (done.exit_code, done.stdout) == (1, "")
    assert untold(done.stderr, "model nothing") == []


def test_the_curve_as_table_and_picture(on_twin: Run, tmp_path: Path) -> None:
    file = tmp_path / "curve.svg"
    words = ("runout", "scey", "--mu", "0.45", "--table")
    done = on_twin(*words, "--plot", str(file))
    assert done.exit_code == 0, done.stderr
    assert max(map(len, done.stdout.splitlines())) <= 80
    table = done.stdout.split("F(μ) on scey")[1]
    rows = [line.split() for line in table.splitlines() if line.strip()[:1].isdigit()]
    assert 15 <= len(rows) <= 31
    assert untold(table, "beyond the profile", "does not move", "dx/dμ") == []
    assert "<svg" in file.read_text(encoding="utf-8")
    document = json.loads(on_twin("--json", *words).stdout)
    by_mu = {row["mu"]: row for row in document["table"]}
    assert by_mu[0.45]["runout_x_m"] == pytest.approx(document["runout_x_m"])
    # What people read is a row of the document.
    shown = next(row for row in rows if row[-1].lstrip("-").isdigit())
    there = by_mu[float(shown[0])]
    assert shown[1] == f"{there['runout_x_m']:.1f}"
    assert shown[3] == f"{there['dx_dmu_m']:.0f}"


def test_a_run_as_picture(on_twin: Run, tmp_path: Path) -> None:
    for mu in ("0.45", "0.2", "3"):
        file = tmp_path / f"{mu}.svg"
        done = on_twin("runout", "scey", "--mu", mu, "--plot", str(file))
        assert done.exit_code == 0, done.stderr
        assert "<svg" in file.read_text(encoding="utf-8")
    wrong = on_twin("runout", "scey", "--mu", "0.4", "--plot", str(tmp_path / "run.txt"))
    assert (wrong.exit_code, wrong.stdout) == (1, "")
    assert untold(wrong.stderr, ".png") == []
