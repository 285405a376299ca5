"""`hazard` on ten times as many paths: time and peak memory of processes by themselves."""

from __future__ import annotations

import tempfile

import numpy as np

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.cases.made_region import region
from benchmarks.measuring import Result, alone

N_PATHS, TIMES, RECORDS = 1000, 10, 3
MOST_MEMORY = 1.2
PROCESS = """
import json, sys, time
from avahazard.workflow.hazard import run_hazard
from avahazard.workflow.requests import HazardRequest
from benchmarks.measuring import peak_mb
run_hazard(sys.argv[1], "m", HazardRequest(return_periods=100, paths=sys.argv[2]))
begun = time.process_time()
run_hazard(sys.argv[1], "m", HazardRequest(return_periods=100))
print(json.dumps([time.process_time() - begun, peak_mb()]))
"""


def measure() -> Result:
    """The model is calibrated on some of the paths, and applied to all; few, many, few."""
    found: dict[int, list[list[float]]] = {N_PATHS: [], TIMES * N_PATHS: []}
    with tempfile.TemporaryDirectory() as folder:
        names = [f"P{k:02d}" for k in range(1, 21)]
        databases = {n: region(folder, n, RECORDS * n) for n in found}
        for n in (N_PATHS, TIMES * N_PATHS, N_PATHS):
            if not found[n]:
                calibrate(databases[n], "m", CalibrateRequest(paths=names, draws=1000))
            found[n].append(alone(PROCESS, databases[n], names[0]))
    few_s, few_mb = np.mean(found[N_PATHS], axis=0)
    many_s, many_mb = np.mean(found[TIMES * N_PATHS], axis=0)
    memory = many_mb / few_mb
    return Result(
        float(many_s / few_s),
        float(many_s),
        float(few_s),
        "CPU-s",
        11.0,
        True,
        f"time of {TIMES * N_PATHS} paths over that of {N_PATHS}",
        f"T = 100 years, {RECORDS} records a path. Peak memory {many_mb:.0f} against {few_mb:.0f} "
        f"MB: {memory:.2f} times (wanted: {MOST_MEMORY:g}).",
    )
