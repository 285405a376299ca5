"""Projects for AvaFrame: what is in them, and that the real one runs them."""

from __future__ import annotations

import configparser
import csv
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import rasterio
import shapely

from avahazard.store.records import load_simulations
from avahazard.store.session import reading
from tests.conftest import command_line
from tests.engines.slope import NORTH, WEST, real_avaframe, stop_m


def _settings(file: Path) -> configparser.ConfigParser:
    found = configparser.ConfigParser()
    found.read(file)
    return found


def _draws(project: Path) -> list[dict[str, float]]:
    with (project / "draws.csv").open(newline="") as file:
        return [
            {k: float(v) for k, v in row.items() if k != "release"} for row in csv.DictReader(file)
        ]


def test_each_draw_has_its_release_and_settings(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    asked = ("export", "flow", "--avaframe", str(flow_slope / "projects"), "--draws", "5")
    found = run("--json", *asked)
    assert found.exit_code == 0, found.output
    assert json.loads(found.stdout)["layers"][0]["n_features"] == 5
    project = flow_slope / "projects" / "P01"
    main = _settings(project / "Inputs" / "CFGs" / "com1DFACfg.ini")
    assert main["INPUT"]["releaseScenario"] == "release"
    assert 0.3 < float(main["GENERAL"]["mucoulomb"]) < 0.45
    draws = _draws(project)
    assert len(draws) == 5
    for k, one in enumerate(draws, 1):
        settings = _settings(project / "draws" / f"draw{k:03d}_com1DFACfg.ini")
        assert float(settings["GENERAL"]["mucoulomb"]) == pytest.approx(one["friction"], rel=1e-4)
        release = settings["INPUT"]["releaseScenario"]
        _, _, geometry, _ = pyogrio.raw.read(project / "Inputs" / "REL" / f"{release}.shp")
        area = shapely.from_wkb(geometry[0])
        slope = 1.6 * np.exp((WEST - area.centroid.x) / 500.0)
        volume = float(settings["GENERAL"]["relTh"]) * area.area * np.hypot(1.0, slope)
        assert volume == pytest.approx(one["volume_m3"], rel=0.1)
    again = run(*asked)
    assert again.exit_code == 1
    assert "projects is there already" in again.stderr


@pytest.mark.parametrize("law", ["exponential", pytest.param("constant", marks=pytest.mark.slow)])
def test_the_rates_of_draws_are_those_of_the_map(flow_slope: Path, law: str) -> None:
    run = command_line(flow_slope / "avahazard.db")
    for words in (
        ("calibrate", law, "--law", law, "--forward", "com1dfa", "--draws", "100"),
        ("map", law, "-o", str(flow_slope / "chances.tif")),
        ("export", law, "--avaframe", str(flow_slope / "many"), "--draws", "999"),
    ):
        found = run(*words)
        assert found.exit_code == 0, found.output
    draws = _draws(flow_slope / "many" / "P01")
    assert len({one["volume_m3"] for one in draws}) > 5
    stops = np.array([stop_m(one["friction"], one["volume_m3"]) for one in draws])
    per_year = np.array([one["per_year"] for one in draws])
    x = np.array([900.0, 1200.0, 1400.0, 1500.0, 1600.0])
    with rasterio.open(flow_slope / "chances.tif") as raster:
        places = [(WEST + 100.0 + at, NORTH - 300.0) for at in x]
        chance = np.array([value[0] for value in raster.sample(places, indexes=1)])
    rate = np.array([per_year[stops > at].sum() for at in x])
    assert -np.expm1(-rate) == pytest.approx(chance, abs=0.05)
    assert chance[0] > 0.9
    assert chance[-1] < 0.8


def test_bad_usage_is_told(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    assert run("export", "flow").exit_code == 2
    both = run("export", "flow", "-o", "a.csv", "--avaframe", "b")
    assert both.exit_code == 2
    assert "Give one of" in both.stderr
    found = run("export", "flow", "--avaframe", str(flow_slope / "none" / "b"))
    assert found.exit_code == 1
    assert "There is no folder" in found.stderr
    (flow_slope / "full").mkdir()
    (flow_slope / "full" / "mine.txt").write_text("keep")
    assert run("export", "flow", "--avaframe", str(flow_slope / "full")).exit_code == 1
    assert (flow_slope / "full" / "mine.txt").read_text() == "keep"


@pytest.mark.slow
def test_the_real_avaframe_runs_a_project_as_simulate_does(
    flow_slope: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python = real_avaframe()
    run = command_line(flow_slope / "avahazard.db")
    folder = flow_slope / "projects"
    assert run("export", "flow", "--avaframe", str(folder), "--draws", "2").exit_code == 0
    project = folder / "P01"
    for words in (["-m", "avaframe.runCom1DFA", str(project)], [str(project / "run_draws.py")]):
        done = subprocess.run(
            [python, *words], env={**os.environ, "MPLBACKEND": "Agg"}, cwd=folder, check=False
        )
        assert done.returncode == 0
    assert list((project / "Outputs" / "ana4Stats").glob("*_prob__ppr_lim1.0.tif"))
    peaks = project / "Outputs" / "com1DFA" / "peakFiles"
    first = _draws(project)[0]
    monkeypatch.setenv("AVAHAZARD_AVAFRAME", python)
    volume, friction = str(first["volume_m3"]), str(first["friction"])
    assert run("simulate", "-V", volume, "--friction", friction).exit_code == 0
    with reading(str(flow_slope / "avahazard.db")) as session:
        stored = load_simulations(session, peaks=True)
    (selected,) = (one for one in stored if one.volume_m3 == first["volume_m3"])
    (file,) = peaks.glob("draw001_*_ppr.tif")
    with rasterio.open(file) as raster:
        peak = raster.read(1, masked=True).filled(0.0)
    assert selected.peak_kpa is not None
    # Thickness is rounded in the sixth digit, which moves particles a little.
    over = (peak > 1.0) == (selected.peak_kpa > 1.0)
    assert over.mean() > 0.99
