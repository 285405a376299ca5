"""`hazard` on ten times as many paths: time and peak memory of a process by itself."""

from __future__ import annotations

import tempfile

from avahazard.workflow.calibrate import calibrate
from benchmarks.cases.made_region import region
from benchmarks.measuring import Result, alone

N_PATHS, TIMES, RECORDS = 1000, 10, 3
MOST_MEMORY = 1.2
PROCESS = """
import json, sys, time
from avahazard.workflow.hazard import HazardQuestion, run_hazard
from benchmarks.measuring import peak_mb
run_hazard(sys.argv[1], "m", HazardQuestion([100.0], paths=[sys.argv[2]]))
begun = time.process_time()
run_hazard(sys.argv[1], "m", HazardQuestion([100.0]))
print(json.dumps([time.process_time() - begun, peak_mb()]))
"""


def measure() -> Result:
    """The model is calibrated on some of the paths, and applied to all."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for n in (N_PATHS, TIMES * N_PATHS):
            database = region(folder, n, RECORDS * n)
            names = [f"P{k:02d}" for k in range(1, 21)]
            calibrate(database, "m", paths=names, draws=1000)
            found[n] = alone(PROCESS, database, names[0])
    (few_s, few_mb), (many_s, many_mb) = found.values()
    memory = many_mb / few_mb
    return Result(
        many_s / few_s,
        many_s,
        few_s,
        "CPU-s",
        11.0,
        True,
        f"time of {TIMES * N_PATHS} paths over that of {N_PATHS}",
        f"T = 100 years, {RECORDS} records a path. Peak memory {many_mb:.0f} against {few_mb:.0f} "
        f"MB: {memory:.2f} times (wanted: {MOST_MEMORY:g}).",
    )
