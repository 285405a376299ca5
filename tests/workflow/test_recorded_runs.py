"""Recorded runs of the real com1DFA: friction is found again, and the block is behind."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avahazard.effects.site import stop_table
from avahazard.hazard.exceedance import friction_below, yearly_rate
from avahazard.hazard.frequency import volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.records.collection import Simulation
from avahazard.store.session import reading
from avahazard.workflow.by_path import survey
from avahazard.workflow.flow import map_parts
from avahazard.workflow.hazard import load_limits
from avahazard.workflow.requests import MapRequest
from avahazard.workflow.stored import load_stored
from tests.conftest import command_line
from tests.engines.valleys import FRICTIONS, NAMES, WITH_PEAKS, import_valleys, store_recorded

A, N, SIGMA = 0.36, 2e-6, 0.03
PER_VALLEY, SEED = 8, 11
END_X_M = 1880.0


def drawn_records(runs: list[Simulation]) -> str:
    """Records of known friction, whose stops are those of com1DFA between its runs."""
    rng = np.random.default_rng(SEED)
    lines = ["event_id,path_id,date,runout_x_m,runout_sigma_m,volume_m3,volume_rel_sigma"]
    for name in NAMES:
        table = stop_table([run for run in runs if run.path_id == name], 0.0, END_X_M)
        for k in range(PER_VALLEY):
            stop = np.inf
            while not np.isfinite(stop):
                volume = float(np.exp(rng.uniform(np.log(3e3), np.log(4e4))))
                mu = A * np.exp(-N * volume + SIGMA * rng.standard_normal())
                stop = float(table.at(volume, np.array([mu]))[0])
            there = stop + 10.0 * rng.standard_normal()
            lines.append(f"{name}-{k},{name},{1970 + 5 * k}-02-01,{there:.1f},10,{volume:.0f},0.05")
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def valleys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a database of recorded runs and records, and models by both engines."""
    folder = tmp_path_factory.mktemp("valleys")
    database = import_valleys(folder)
    runs = store_recorded(database)
    (folder / "events.csv").write_text(drawn_records(runs))
    run = command_line(database)
    for words in (
        ["import", str(folder / "events.csv")],
        ["calibrate", "flow", "--forward", "com1dfa", "--draws", "500"],
        ["calibrate", "block", "--draws", "500"],
    ):
        done = run(*words)
        assert done.exit_code == 0, done.output
    return folder


def test_the_friction_is_found_again(valleys: Path) -> None:
    run = command_line(valleys / "valleys.db")
    found = json.loads(run("--json", "model", "flow").stdout)["parameters"]
    for name, true in (("a", A), ("n", N), ("sigma", SIGMA)):
        assert found[name]["q05"] < true < found[name]["q95"]
    assert found["a"]["q95"] - found["a"]["q05"] < 0.05


def test_the_held_out_error_is_less_than_that_of_the_block(valleys: Path) -> None:
    run = command_line(valleys / "valleys.db")
    errors = {}
    for name in ("flow", "block"):
        told = json.loads(run("--json", "compare", name).stdout)
        errors[name] = told["held_out"]["runout"]["crps_m"]
    assert errors["flow"] < errors["block"]


def test_the_chance_along_the_line_is_the_exceedance_of_the_table(valleys: Path) -> None:
    database = str(valleys / "valleys.db")
    model, records = load_stored(database, "flow")
    request = MapRequest(paths=[WITH_PEAKS])
    (part,), _ = map_parts(database, model, records, request, load_limits("swiss"))
    with reading(database) as session:
        volumes = volume_frequencies(survey(session).volumes, request.seed, request.source)
    rate = volumes.of(WITH_PEAKS).volumes()
    avalanches = path_hazard(model, records, WITH_PEAKS, rate, seed=0).avalanches
    table = stop_table(part.runs, 0.0, END_X_M)
    fine = np.linspace(FRICTIONS[0], FRICTIONS[-1], 2001)
    stops = [table.at(float(np.exp(v)), fine) for v in avalanches.volumes.log_volume]
    middle = part.crop.elevation_m.shape[0] // 2
    place, chance = part.place[middle], part.bands["chance"][middle]
    falling = chance[(place > 1000.0) & (place < END_X_M)]
    assert len(falling) > 80
    assert np.all(np.diff(falling) <= 1e-9)
    for x in place[(place > 1000.0) & (place < 1800.0)][::5]:
        most = np.array([fine[stop >= x].max(initial=0.0) for stop in stops])
        passes = yearly_rate(avalanches, friction_below(avalanches, most[None, None, :]))
        by_table = -np.expm1(-passes).mean()
        assert chance[place == x] == pytest.approx(by_table, abs=0.01)
    middles = [part.runout("chance", t) for t in (10.0, 30.0, 100.0, 300.0)]
    assert middles == sorted(middles)
