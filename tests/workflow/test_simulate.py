"""Runs of a flow model, calibration on them and maps, with a program in AvaFrame's place."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import rasterio

from avahazard.engines.com1dfa import PLACE
from avahazard.store.session import reading
from avahazard.store.simulations import load_simulations
from tests.conftest import command_line, missing
from tests.engines.slope import LAW, stop_m, write_program, write_slope
from tests.once import made_once

TABLE = [f"--friction={mu:.3f}" for mu in np.linspace(0.2, 0.6, 9)]


def _make(folder: Path) -> None:
    write_slope(folder)
    program = write_program(folder)
    database = folder / "avahazard.db"
    run = command_line(database)
    os.environ[PLACE] = str(program)
    try:
        for words in (
            ["init"],
            ["import", str(folder / "line.gpkg"), "--dem", str(folder / "dem.tif")],
            ["import", str(folder / "events.csv")],
            ["simulate", "-V", "3000", "-V", "40000", *TABLE],
            ["calibrate", "flow", "--forward", "com1dfa", "--draws", "250"],
        ):
            found = run(*words)
            assert found.exit_code == 0, found.output
    finally:
        del os.environ[PLACE]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a database of runs and a model calibrated on them; do not write to it."""
    return made_once(tmp_path_factory, "simulated-slope", _make)


@pytest.fixture
def there(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a copy of it."""
    monkeypatch.setenv(PLACE, str(made / "python"))
    return Path(shutil.copytree(made, tmp_path / "slope"))


def test_runs_are_stored_with_their_stops_and_none_is_made_twice(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    again = run("--json", "simulate", "-V", "3000", *TABLE)
    (row,) = json.loads(again.stdout)
    assert (row["n_runs"], row["n_new"]) == (18, 0)
    with reading(str(there / "avahazard.db")) as session:
        runs = load_simulations(session, peaks=True)
    for one in runs:
        assert one.stop_x_m == pytest.approx(stop_m(one.friction, one.volume_m3), abs=20.0)
        assert one.peak_kpa is not None
        assert one.peak_kpa.max() > 2.0


def test_between_far_stops_more_frictions_are_run(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    found = run("--json", "simulate", "-V", "12000")
    assert found.exit_code == 0, found.output
    with reading(str(there / "avahazard.db")) as session:
        runs = [r for r in load_simulations(session) if r.volume_m3 == 12000.0]
    assert len(runs) > 8
    far = [a.stop_x_m - b.stop_x_m for a, b in pairwise(runs)]
    steps = np.diff([r.friction for r in runs])
    assert all(gap <= 50.0 or step < 0.02 for gap, step in zip(far, steps, strict=True))


def test_a_plan_runs_nothing_and_paths_without_terrain_are_told(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    plan = json.loads(run("--json", "simulate", "--dry-run").stdout)
    assert plan["n_runs"] >= 32
    bare = there / "bare"
    bare.mkdir()
    (bare / "paths.csv").write_text("path_id\nP02\n")
    points = "".join(f"P02,{x},{500 - 0.4 * x}\n" for x in range(0, 901, 100))
    (bare / "profiles.csv").write_text(f"path_id,x_m,y_m\n{points}")
    assert run("import", str(bare)).exit_code == 0
    found = run("simulate", "P02")
    assert found.exit_code == 1
    assert "There is no terrain for P02" in found.stderr


def test_a_failed_run_is_told_and_keeps_those_before(there: Path) -> None:
    program = there / "python"
    text = program.read_text().replace("mu = float", 'assert 0, "it broke"\nmu = float')
    broken = there / "broken"
    broken.write_text(text)
    broken.chmod(0o755)
    os.environ[PLACE] = str(broken)
    found = command_line(there / "avahazard.db")("simulate", "-V", "5000", "--friction", "0.3")
    assert found.exit_code == 1
    assert "com1DFA failed on path P01" in found.stderr
    assert "it broke" in found.stderr
    with reading(str(there / "avahazard.db")) as session:
        assert len(load_simulations(session)) == 18


def test_killing_it_loses_no_finished_run(there: Path) -> None:
    database = str(there / "avahazard.db")
    rng = np.random.default_rng(0)
    seen = 18
    for _ in range(3):
        words = [sys.executable, "-c", "from avahazard.cli.main import main; main()"]
        words += ["--db", database, "simulate", "-V", "9000", "--workers", "2", *TABLE]
        child = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(float(rng.uniform(1.5, 4.0)))
        child.send_signal(signal.SIGKILL)
        child.wait()
        with reading(database) as session:
            now = len(load_simulations(session))
        assert now >= seen
        seen = now
    assert command_line(database)("simulate", "-V", "9000", *TABLE).exit_code == 0
    with reading(database) as session:
        assert len(load_simulations(session)) == 27


def test_a_model_on_the_runs_finds_the_friction_and_beats_the_block(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    flow = json.loads(run("--json", "model", "flow").stdout)
    assert flow["forward"] == "com1dfa"
    for name, true in zip(("a", "n"), LAW, strict=True):
        found = flow["parameters"][name]
        assert abs(found["mean"] - true) < 3.0 * found["sd"]
    assert run("calibrate", "block", "--draws", "250").exit_code == 0
    errors = {}
    for name in ("flow", "block"):
        told = json.loads(run("--json", "compare", name).stdout)
        errors[name] = told["held_out"]["runout"]["crps_m"]
    assert errors["flow"] < errors["block"]
    refused = run("hazard", "flow")
    assert refused.exit_code == 1
    assert "avahazard map flow" in refused.stderr


def test_without_runs_of_a_path_the_calibration_says_how_to_make_them(
    there: Path, database: str
) -> None:
    run = command_line(database)
    run("import", str(there / "line.gpkg"), "--dem", str(there / "dem.tif"))
    run("import", str(there / "events.csv"))
    found = run("calibrate", "flow", "--forward", "com1dfa")
    assert found.exit_code == 1
    assert "avahazard simulate P01" in found.stderr


def test_the_map_as_raster_and_as_areas(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    raster = there / "chance.tif"
    told = json.loads(run("--json", "map", "flow", "-o", str(raster)).stdout)
    assert told["paths"][0]["engine"] == "com1dfa"
    with rasterio.open(raster) as source:
        names = source.descriptions
        bands = {name: source.read(k) for k, name in enumerate(names, 1)}
        assert source.crs.to_epsg() == 31287
        row, _ = source.index(380_100.0, 400_300.0)
    chance = bands["chance"]
    assert np.isfinite(chance).all()
    assert (bands["chance_30_kpa"] <= bands["chance_3_kpa"] + 1e-6).all()
    assert (bands["chance_3_kpa"] <= chance + 1e-6).all()
    assert (np.diff(chance[row, 30:]) <= 1e-6).all()
    assert set(np.unique(bands["engine"])) == {2.0}
    areas = there / "areas.gpkg"
    assert run("map", "flow", "-o", str(areas)).exit_code == 0
    layers = {name for name, _ in pyogrio.list_layers(areas)}
    assert {"zone_areas", "return_periods", "paths", "layer_styles"} <= layers
    assert run("map", "flow", "-o", str(there / "map.pdf")).exit_code == 1


def test_paths_without_runs_are_drawn_along_the_line(there: Path) -> None:
    run = command_line(there / "avahazard.db")
    assert run("calibrate", "block", "--draws", "250").exit_code == 0
    raster = there / "block.tif"
    found = run("map", "block", "-o", str(raster))
    assert found.exit_code == 0, found.output
    assert "calibrated for the block" in found.stderr
    with closing(sqlite3.connect(there / "avahazard.db")) as whole, whole:
        whole.execute("DELETE FROM simulations")
    told = json.loads(run("--json", "map", "block", "-o", str(raster)).stdout)
    assert told["paths"][0]["engine"] == "block"
    with rasterio.open(raster) as source:
        chance, engine = source.read(1), source.read(source.count)
    drawn = np.isfinite(chance)
    assert 0 < drawn.sum() < chance.size / 2
    assert set(np.unique(engine[drawn])) == {1.0}
    assert drawn.any(axis=1).sum() == pytest.approx(80.0 / told["cell_m"], abs=2)
    assert run("map", "flow", "-o", str(raster)).exit_code == 1


@pytest.mark.slow
def test_the_real_com1dfa(there: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    named = os.environ.get("AVAHAZARD_REAL_AVAFRAME") or ".avaframe-venv/bin/python"
    if not Path(named).exists():
        missing("AvaFrame is not there: make avaframe")
    monkeypatch.setenv(PLACE, str(Path(named).absolute()))
    run = command_line(there / "avahazard.db")
    found = run("simulate", "-V", "10000", "--friction", "0.3", "--friction", "0.4")
    assert found.exit_code == 0, found.output
    with reading(str(there / "avahazard.db")) as session:
        near, far = (r for r in load_simulations(session) if r.volume_m3 == 10000.0)
    assert near.stop_x_m > far.stop_x_m > 500.0
