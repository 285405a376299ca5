"""`avahazard fit`."""

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
    fits = {entry["law"]: entry for entry in document("fit")}
    assert fits.keys() == {"exponential", "power", "rational", "constant"}
    exponential = fits["exponential"]
    se = [parameter["se"] for parameter in exponential["parameters"].values()]
    assert np.sqrt(np.diag(exponential["covariance"])) == pytest.approx(se)
    a = exponential["parameters"]["a"]
    assert abs(a["value"] - 0.519) < 3.0 * a["se"]
    assert exponential["n_events"] == 170


def test_people_see_a_table_and_what_was_left_out(on_twin: Run) -> None:
    done = on_twin("fit")
    assert done.exit_code == 0
    assert "μ = a exp(-n V)" in done.stdout
    assert untold(done.stderr, 3, 173) == []
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_rock_avalanches_without_profiles(avahazard: Run, shared_data: Path) -> None:
    avahazard("import", str(shared_data / "rock-avalanches-canada"))
    power = json.loads(avahazard("--json", "fit").stdout)[1]
    assert power["parameters"]["beta"]["value"] == pytest.approx(0.085, abs=0.01)


def test_nothing_to_fit(avahazard: Run, write: Callable[[str, str], Path]) -> None:
    head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
    avahazard("import", str(write("events.csv", head + "a,500,1000,\nb,500,900,3e4\n")))
    done = avahazard("fit")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "there is 1" in done.stderr
    assert "volume_m3" in done.stderr


def test_laws_with_too_many_constants_are_left_out(
    avahazard: Run, write: Callable[[str, str], Path]
) -> None:
    head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
    avahazard("import", str(write("events.csv", head + "a,500,1000,2e4\nb,500,900,3e4\n")))
    done = avahazard("--json", "fit")
    assert [entry["law"] for entry in json.loads(done.stdout)] == ["constant"]
    assert untold(done.stderr, "3 events") == []


def test_one_path_and_its_picture(on_twin: Run, tmp_path: Path) -> None:
    """As the paper's figure 1: the laws on the points of a path."""
    file = tmp_path / "laws.svg"
    done = on_twin("--json", "fit", "--path", "saint-clement", "--plot", str(file))
    fits = json.loads(done.stdout)
    assert {entry["n_events"] for entry in fits} == {42}
    drawn = file.read_text(encoding="utf-8")
    assert drawn.count('<g id="line2d_') > len(fits)
    refused = on_twin("fit", "--plot", str(tmp_path / "laws.txt"))
    assert refused.exit_code == 1
    assert "not the name of a picture" in refused.stderr
    assert on_twin("fit", "--path", "nowhere").exit_code == 1


def test_every_path_of_the_demo_by_itself(on_twin: Run) -> None:
    """Two of the seven ended in a traceback."""
    for name in ("gurraz", "saugy", "scey", "entremene", "nants", "grand-chantey"):
        done = on_twin("--json", "fit", "--path", name)
        assert done.exit_code == 0
        assert "constant" in [entry["law"] for entry in json.loads(done.stdout)]
