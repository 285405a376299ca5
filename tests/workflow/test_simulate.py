"""Runs of a flow model, calibration on them and maps, with a program in AvaFrame's place."""

from __future__ import annotations

import json
import os
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
from tests.engines.slope import LAW, stop_m
from tests.workflow.slope import TABLE


def test_runs_are_stored_with_their_stops_and_none_is_made_twice(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    again = run("--json", "simulate", "-V", "3000", *TABLE)
    (row,) = json.loads(again.stdout)
    assert (row["n_runs"], row["n_new"]) == (18, 0)
    with reading(str(flow_slope / "avahazard.db")) as session:
        runs = load_simulations(session, peaks=True)
    for one in runs:
        assert one.stop_x_m == pytest.approx(stop_m(one.friction, one.volume_m3), abs=20.0)
        assert one.peak_kpa is not None
        assert one.peak_kpa.max() > 2.0


def test_between_far_stops_more_frictions_are_run(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    found = run("--json", "simulate", "-V", "12000")
    assert found.exit_code == 0, found.output
    with reading(str(flow_slope / "avahazard.db")) as session:
        runs = [r for r in load_simulations(session) if r.volume_m3 == 12000.0]
    assert len(runs) > 8
    far = [a.stop_x_m - b.stop_x_m for a, b in pairwise(runs)]
    steps = np.diff([r.friction for r in runs])
    assert all(gap <= 50.0 or step < 0.02 for gap, step in zip(far, steps, strict=True))


def test_a_plan_runs_nothing_and_paths_without_terrain_are_told(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    plan = json.loads(run("--json", "simulate", "--dry-run").stdout)
    assert plan["n_runs"] >= 32
    bare = flow_slope / "bare"
    bare.mkdir()
    (bare / "paths.csv").write_text("path_id\nP02\n")
    points = "".join(f"P02,{x},{500 - 0.4 * x}\n" for x in range(0, 901, 100))
    (bare / "profiles.csv").write_text(f"path_id,x_m,y_m\n{points}")
    assert run("import", str(bare)).exit_code == 0
    found = run("simulate", "P02")
    assert found.exit_code == 1
    assert "There is no terrain for P02" in found.stderr


def test_a_failed_run_is_told_and_keeps_those_before(flow_slope: Path) -> None:
    program = flow_slope / "python"
    text = program.read_text().replace("mu = float", 'assert 0, "it broke"\nmu = float')
    broken = flow_slope / "broken"
    broken.write_text(text)
    broken.chmod(0o755)
    os.environ[PLACE] = str(broken)
    found = command_line(flow_slope / "avahazard.db")("simulate", "-V", "5000", "--friction", "0.3")
    assert found.exit_code == 1
    assert "com1DFA failed on path P01" in found.stderr
    assert "it broke" in found.stderr
    with reading(str(flow_slope / "avahazard.db")) as session:
        assert len(load_simulations(session)) == 18


def test_killing_it_loses_no_finished_run(flow_slope: Path) -> None:
    database = str(flow_slope / "avahazard.db")
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


def test_a_model_on_the_runs_finds_the_friction_and_beats_the_block(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
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
    flow_slope: Path, database: str
) -> None:
    run = command_line(database)
    run("import", str(flow_slope / "line.gpkg"), "--dem", str(flow_slope / "dem.tif"))
    run("import", str(flow_slope / "events.csv"))
    found = run("calibrate", "flow", "--forward", "com1dfa")
    assert found.exit_code == 1
    assert "avahazard simulate P01" in found.stderr


def test_the_map_as_raster_and_as_areas(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    raster = flow_slope / "chance.tif"
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
    areas = flow_slope / "areas.gpkg"
    assert run("map", "flow", "-o", str(areas)).exit_code == 0
    layers = {name for name, _ in pyogrio.list_layers(areas)}
    assert {"zone_areas", "return_periods", "paths", "layer_styles"} <= layers
    assert run("map", "flow", "-o", str(flow_slope / "map.pdf")).exit_code == 1


def test_paths_without_runs_are_drawn_along_the_line(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    assert run("calibrate", "block", "--draws", "250").exit_code == 0
    raster = flow_slope / "block.tif"
    found = run("map", "block", "-o", str(raster))
    assert found.exit_code == 0, found.output
    assert "calibrated for the block" in found.stderr
    with closing(sqlite3.connect(flow_slope / "avahazard.db")) as whole, whole:
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
def test_the_real_com1dfa(flow_slope: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    named = os.environ.get("AVAHAZARD_REAL_AVAFRAME") or ".avaframe-venv/bin/python"
    if not Path(named).exists():
        missing("AvaFrame is not there: make avaframe")
    monkeypatch.setenv(PLACE, str(Path(named).absolute()))
    run = command_line(flow_slope / "avahazard.db")
    found = run("simulate", "-V", "10000", "--friction", "0.3", "--friction", "0.4")
    assert found.exit_code == 0, found.output
    with reading(str(flow_slope / "avahazard.db")) as session:
        near, far = (r for r in load_simulations(session) if r.volume_m3 == 10000.0)
    assert near.stop_x_m > far.stop_x_m > 500.0
