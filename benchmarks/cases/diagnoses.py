"""`diagnose` against a limit of time: nobody else offers it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from statistics import median

import numpy as np
import pandas as pd

from avahazard.criticism.diagnosis.diagnose import diagnose as diagnose_
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.measuring import Row, all_cores, alone, seconds
from benchmarks.study import SHARED

LIMIT_S, RECORDS_LIMIT_S, LIMIT_MB = 60.0, 300.0, 1024
DRAG = {"turbulent-drag": 1.0}
WORLDS = {
    "season": ({"season": 1.0}, Settings()),
    "drag, speeds": (DRAG, Settings(speeds=0.2)),
    "nothing missing": ({}, Settings()),
}
TRACKS_SHARE = 75 / 240
TIMES, MOVED = 24, 0.1
"""Each slide stands so often, all but once with H, L and V moved by so much (sd of the log)."""
PROCESS = """
import json, sys, time
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import DiagnoseRequest
from benchmarks.measuring import peak_mb
diagnose_model(sys.argv[2], "m", DiagnoseRequest())
begun = time.process_time()
diagnose_model(sys.argv[1], "m", DiagnoseRequest())
print(json.dumps([time.process_time() - begun, peak_mb()]))
"""


def _diagnosis(observations: Observations) -> object:
    """What the command computes."""
    return diagnose_(observations, Specification(), {})


def diagnose() -> Row:
    """Seconds on 240 events of 9 paths on two cores, once compiled; the median of `WORLDS`."""
    found = {}
    with all_cores():
        for k, (name, (effects, settings)) in enumerate(WORLDS.items()):
            observations = build_observations(make_dataset(70 + k, 240, 9, effects, settings)[0])
            _diagnosis(observations)  # compiles
            found[name] = seconds(lambda observations=observations: _diagnosis(observations))
    times = ", ".join(f"{name} {time:.0f} s" for name, time in found.items())
    note = (
        f"240 events on 9 paths, 199 simulated datasets (fewer where nothing is missing): {times}. "
        "*Theirs* is the limit, since no other program has a diagnosis."
    )
    return median(found.values()) / LIMIT_S, median(found.values()), LIMIT_S, note


def diagnose_speeds() -> Row:
    """Seconds on 240 events with speeds along 75 tracks, by a thread for each core."""
    settings = Settings(speeds=TRACKS_SHARE)
    small, observations = (
        build_observations(make_dataset(seed, n_events, n_paths, DRAG, settings)[0])
        for seed, n_events, n_paths in ((72, 40, 4), (71, 240, 9))
    )
    with all_cores():
        _diagnosis(small)  # compiles
        ours = seconds(lambda: _diagnosis(observations))
    n = [len(m.x) for m in observations.speeds]
    note = (
        f"240 events on 9 paths, hidden drag, {len(n)} tracks of {sum(n) / len(n):.0f} speeds, at "
        f"most 199 simulated datasets, {os.cpu_count()} cores. Theirs is the limit."
    )
    return ours / LIMIT_S, ours, LIMIT_S, note


def diagnose_records() -> Row:
    """CPU seconds of the use case on 13,392 records without profiles, compiled on the first 558."""
    with tempfile.TemporaryDirectory() as folder:
        small, large = _slides(folder, 1), _slides(folder, TIMES)
        ours, peak = alone(PROCESS, large, small)
    note = (
        f"558 slides of the sea floor, {TIMES} times over, moved by {100 * MOVED:.0f} %: power "
        f"law, 199 simulated datasets at most. Peak memory {peak:.0f} MB (target: {LIMIT_MB}). "
        "*Theirs* is the limit."
    )
    return ours / RECORDS_LIMIT_S, ours, RECORDS_LIMIT_S, note


def _slides(folder: str, times: int) -> str:
    """A database with the slides so many times, and a model of them."""
    slides = pd.read_csv(SHARED / "submarine-slides" / "events.csv")
    table = pd.concat([slides] * times, ignore_index=True)
    table["event_id"] = [f"{k // len(slides)}-{k % len(slides)}" for k in range(len(table))]
    columns = ["fall_height_m", "runout_length_m", "volume_m3"]
    sd = np.where(table.index < len(slides), 0.0, MOVED)[:, None]
    table[columns] *= np.exp(sd * np.random.default_rng(1).standard_normal((len(table), 3)))
    file, database = Path(folder) / f"{times}.csv", str(Path(folder) / f"{times}.db")
    table.to_csv(file, index=False)
    init_database(database)
    import_files(database, [file])
    calibrate(database, "m", CalibrateRequest(law="power"))
    return database
