"""`hazard` for three return periods: seconds of a processor for each path of a region."""

from __future__ import annotations

import tempfile

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.hazard import hazard
from avahazard.workflow.requests import CalibrateRequest, HazardRequest
from benchmarks.cases.made_region import cpu_seconds, region
from benchmarks.measuring import Result

BEFORE_S = 0.35
PERIODS = (30.0, 100.0, 300.0)
N_PATHS, N_EVENTS, N_CALIBRATED = 1000, 10_000, 20


def measure() -> Result:
    """The model is calibrated on some of the paths, and applied to all."""
    with tempfile.TemporaryDirectory() as folder:
        database = region(folder, N_PATHS, N_EVENTS)
        names = [f"P{k:02d}" for k in range(1, N_CALIBRATED + 1)]
        calibrate(database, "m", CalibrateRequest(paths=names, draws=1000))
        hazard(database, "m", HazardRequest(return_periods=PERIODS, paths=names))  # compiles
        ours = (
            cpu_seconds(lambda: hazard(database, "m", HazardRequest(return_periods=PERIODS)))
            / N_PATHS
        )
    return Result(
        BEFORE_S / ours,
        ours,
        BEFORE_S,
        "CPU-s a path",
        7.0,
        False,
        "time of the version before (0.35 s) over ours",
        f"{N_PATHS} made paths of ten records and eight releases each, T = 30, 100, 300 years, the "
        "whole use case: loading, frequencies, runs, bounds, storing.",
    )
