"""Runs of a flow model, calibration on them and maps, with a program in AvaFrame's place."""

from __future__ import annotations

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import numpy as np
import psutil
import pyogrio
import pytest
import rasterio
from scipy.stats import norm
from typer.testing import Result

from avahazard.engines.com1dfa import PLACE
from avahazard.store.records import load_simulations
from avahazard.store.session import reading
from avahazard.workflow import flow
from avahazard.workflow.report import gather
from avahazard.workflow.requests import ReportRequest
from tests.conftest import command_line
from tests.engines.slope import LAW, real_avaframe, stop_m, write_program, write_slope
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


def test_between_far_stops_more_frictions_are_run(
    flow_slope: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three frictions, whose stops are more than 100 m apart."""
    monkeypatch.setattr(flow, "N_FRICTIONS", 3)
    monkeypatch.setattr(flow, "LOWEST", 0.5)
    run = command_line(flow_slope / "avahazard.db")
    found = run("--json", "simulate", "-V", "12000")
    assert found.exit_code == 0, found.output
    with reading(str(flow_slope / "avahazard.db")) as session:
        runs = [r for r in load_simulations(session) if r.volume_m3 == 12000.0]
    assert len(runs) > 3
    far = [a.stop_x_m - b.stop_x_m for a, b in pairwise(runs)]
    steps = np.diff([r.friction for r in runs])
    assert all(gap <= 50.0 or step < 0.02 for gap, step in zip(far, steps, strict=True))


def test_a_plan_runs_nothing_and_paths_without_terrain_are_told(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    plan = json.loads(run("--json", "simulate", "--dry-run").stdout)
    assert plan["n_runs"] >= 32
    assert plan["measured"]
    assert plan["seconds"] > 0.0
    assert plan["stored_bytes"] > 0
    assert "Refinement" in run("simulate", "--dry-run").stdout
    with reading(str(flow_slope / "avahazard.db")) as session:
        assert len(load_simulations(session)) == 18
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
    discontinuous = flow_slope / "broken"
    discontinuous.write_text(text)
    discontinuous.chmod(0o755)
    os.environ[PLACE] = str(discontinuous)
    found = command_line(flow_slope / "avahazard.db")("simulate", "-V", "5000", "--friction", "0.3")
    assert found.exit_code == 1
    assert "com1DFA failed on path P01" in found.stderr
    assert "it broke" in found.stderr
    with reading(str(flow_slope / "avahazard.db")) as session:
        assert len(load_simulations(session)) == 18


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, 2])
def test_killing_it_loses_no_finished_run(flow_slope: Path, times: int) -> None:
    """Each time it is killed soon after it has stored a run."""
    database = str(flow_slope / "avahazard.db")
    rng = np.random.default_rng(0)

    def stored() -> int:
        with reading(database) as session:
            return len(load_simulations(session))

    seen = 18
    for _ in range(times):
        words = [sys.executable, "-c", "from avahazard.cli.main import main; main()"]
        words += ["--db", database, "simulate", "-V", "9000", "--workers", "2", *TABLE]
        child = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        ends = time.monotonic() + 120.0
        while stored() == seen and time.monotonic() < ends:
            time.sleep(0.05)
        time.sleep(float(rng.uniform(0.0, 0.5)))
        child.send_signal(signal.SIGKILL)
        child.wait()
        now = stored()
        assert now > seen
        seen = now
    assert command_line(database)("simulate", "-V", "9000", *TABLE).exit_code == 0
    assert stored() == 27


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
    assert run("diagnose", "flow").exit_code == 0
    assert "map flow -o flow.tif" in run("ladder").stdout
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


def test_the_report_has_the_map_over_the_terrain(flow_slope: Path) -> None:
    run = command_line(flow_slope / "avahazard.db")
    page = flow_slope / "flow.html"
    assert run("report", "flow", "-o", str(page)).exit_code == 0
    text = page.read_text(encoding="utf-8")
    assert "comes here once in 100 years" in text
    assert '<image href="data:image/png;base64,' in text
    content = gather(str(flow_slope / "avahazard.db"), "flow", ReportRequest())
    (view,) = content.paths
    flow = view.plan.flow
    assert flow.chance.shape == view.plan.ground.elevation_m.shape
    middle = [flow.runouts[t].q50 for t in sorted(flow.runouts)]
    assert middle == sorted(middle)
    for x in flow.runouts.values():
        assert x.q05 <= x.q50 <= x.q95
    assert "rows" not in content.lacking


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
def test_the_friction_of_the_real_com1dfa_is_recovered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Records are stops of com1DFA itself, of runs that the calibration does not have."""
    monkeypatch.setenv(PLACE, real_avaframe())
    write_slope(tmp_path, 0)
    run, truth = (command_line(tmp_path / name) for name in ("mine.db", "truth.db"))

    def asked(of: Callable[..., Result], *words: str) -> str:
        found = of(*words)
        assert found.exit_code == 0, found.output
        return found.stdout

    for of in (run, truth):
        asked(of, "init")
        asked(of, "import", str(tmp_path / "line.gpkg"), "--dem", str(tmp_path / "dem.tif"))
    table = [f"--friction={mu:.2f}" for mu in (0.28, 0.32, 0.36, 0.4, 0.44, 0.5)]
    asked(run, "simulate", "-V", "3000", "-V", "30000", *table)
    median, scatter, n = 0.38, 0.08, 10
    rng = np.random.default_rng(3)
    # Quantiles of the normal: the scatter of so few draws would be that of the draw.
    z = rng.permutation(norm.ppf((np.arange(n) + 0.5) / n))
    lines = []
    for k in range(n):
        volume = round(float(np.exp(rng.uniform(np.log(3e3), np.log(3e4)))))
        friction = round(median * float(np.exp(scatter * z[k])), 4)
        asked(truth, "simulate", "-V", str(volume), "--friction", str(friction))
        with reading(str(tmp_path / "truth.db")) as session:
            (one,) = (r for r in load_simulations(session) if r.volume_m3 == volume)
        assert not one.left_profile
        lines.append(f"e{k},P01,{1970 + k}-02-01,{one.stop_x_m:.1f},12,{volume},0.05\n")
    head = "event_id,path_id,date,runout_x_m,runout_sigma_m,volume_m3,volume_rel_sigma\n"
    (tmp_path / "stops.csv").write_text(head + "".join(lines))
    asked(run, "import", str(tmp_path / "stops.csv"))
    words = ("calibrate", "m", "--law", "constant", "--forward", "com1dfa")
    found = json.loads(asked(run, "--json", *words))["parameters"]
    assert found["a"]["q05"] < median < found["a"]["q95"]
    assert found["a"]["q95"] - found["a"]["q05"] < 0.1
    assert found["sigma"]["q05"] < scatter < found["sigma"]["q95"]


@pytest.mark.slow
def test_twenty_paths_by_dask_with_a_killed_worker(tmp_path: Path) -> None:
    write_slope(tmp_path, names=[f"P{k:02d}" for k in range(20)])
    program, database = write_program(tmp_path), tmp_path / "many.db"
    run = command_line(database)
    for words in (
        ["init"],
        ["import", str(tmp_path / "line.gpkg"), "--dem", str(tmp_path / "dem.tif")],
    ):
        assert run(*words).exit_code == 0
    words = [sys.executable, "-c", "from avahazard.cli.main import main; main()"]
    words += ["--db", str(database), "simulate", "-V", "9000", "--friction", "0.3"]
    words += ["--friction", "0.4", "--engine", "dask", "--workers", "2"]
    environment = {**os.environ, PLACE: str(program)}
    child = subprocess.Popen(words, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE)

    def stored() -> int:
        with reading(str(database)) as session:
            return len(load_simulations(session))

    ends = time.monotonic() + 120.0
    while stored() < 5 and time.monotonic() < ends:
        time.sleep(0.2)
    whole = psutil.Process(child.pid)
    running = [p for p in whole.children(recursive=True) if str(program) in p.cmdline()]
    worker = running[0].parent()
    assert worker is not None
    assert worker.pid != child.pid
    worker.kill()
    _, told = child.communicate(timeout=300)
    assert child.returncode == 0, told
    assert stored() == 40
