"""The same `hazard` by two processes against one."""

from __future__ import annotations

import os
import tempfile

from avahazard.engine import close_engine, set_engine
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.hazard import hazard
from avahazard.workflow.requests import CalibrateRequest, HazardRequest
from benchmarks.cases.made_region import region
from benchmarks.measuring import Result, alternate, seconds

N_PATHS, N_EVENTS, N_CALIBRATED = 300, 3000, 20
PERIODS = (30.0, 100.0, 300.0)


def measure() -> Result:
    """Seconds by the clock; workers are there already, and have compiled."""
    one_core = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") else None
    if one_core is not None:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    with tempfile.TemporaryDirectory() as folder:
        database = region(folder, N_PATHS, N_EVENTS)
        names = [f"P{k:02d}" for k in range(1, N_CALIBRATED + 1)]
        calibrate(database, "m", CalibrateRequest(paths=names, draws=1000))

        def by(workers: int) -> float:
            set_engine("processes", workers=workers)
            hazard(
                database, "m", HazardRequest(return_periods=PERIODS, paths=names[:4])
            )  # starts them
            taken = seconds(lambda: hazard(database, "m", HazardRequest(return_periods=PERIODS)))
            close_engine()
            return taken

        two, one, ratio = alternate(lambda: by(2), lambda: by(1), 2)
    if one_core is not None:
        os.sched_setaffinity(0, one_core)
    return Result(
        ratio,
        two,
        one,
        "s",
        1.7,
        False,
        "time of one process over that of two",
        f"{N_PATHS} made paths of ten records and eight releases each, T = 30, 100, 300 years.",
    )
