"""`calibrate` and `diagnose` on ten times as many events: time and peak memory of a process.

Both diagnoses have as many made worlds as there are at least: how many more a look takes until
chance plainly does as well is itself chance.
"""

from __future__ import annotations

import tempfile

from benchmarks.cases.made_region import region
from benchmarks.measuring import Result, alone

N_EVENTS, TIMES, A_PATH = 2000, 10, 20
MOST_MB = 4096
PROCESS = """
import json, sys, time
from avahazard.criticism.screening.screen import BATCH
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from benchmarks.measuring import peak_mb
calibrate(sys.argv[2], "m", CalibrateRequest(draws=100))
diagnose_model(sys.argv[2], "m", DiagnoseRequest(worlds=39))
times = []
for work in (
    lambda: calibrate(sys.argv[1], "m", CalibrateRequest()),
    lambda: diagnose_model(sys.argv[1], "m", DiagnoseRequest(worlds=BATCH)),
):
    begun = time.process_time()
    work()
    times.append(time.process_time() - begun)
print(json.dumps([*times, peak_mb()]))
"""


def measure() -> Result:
    """Each size in a process of its own, compiled on a small world."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for n in (N_EVENTS, TIMES * N_EVENTS):
            small, database = region(folder, 4, 40 + len(found)), region(folder, n // A_PATH, n)
            found.append(alone(PROCESS, database, small))
    few, many = found
    ours, theirs = sum(many[:2]), sum(few[:2])
    return Result(
        ours / theirs,
        ours,
        theirs,
        "CPU-s",
        11.0,
        True,
        f"time of {TIMES * N_EVENTS} events over that of {N_EVENTS}",
        f"`calibrate` {many[0]:.0f} against {few[0]:.0f} s, `diagnose` {many[1]:.0f} against "
        f"{few[1]:.0f} s with 40 made worlds; {A_PATH} events a path, nothing hidden. "
        f"Peak memory {many[2]:.0f} MB (wanted: {MOST_MB}).",
    )
