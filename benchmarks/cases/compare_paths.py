"""`compare` of a model on many paths with few events each."""

from __future__ import annotations

import tempfile

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.cases.made_region import cpu_seconds, region
from benchmarks.measuring import Result

BEFORE_S = 486.0
N_PATHS, N_EVENTS = 1000, 1000


def measure() -> Result:
    """Seconds of a processor of one comparison."""
    with tempfile.TemporaryDirectory() as folder:
        small = region(folder, 5, 20)
        calibrate(small, "m", CalibrateRequest(draws=200))
        compare(small, "m")  # compiles
        database = region(folder, N_PATHS, N_EVENTS)
        calibrate(database, "m", CalibrateRequest(draws=1000))
        fits = []
        ours = cpu_seconds(lambda: fits.append(compare(database, "m").held_out.n_fits))
    return Result(
        BEFORE_S / ours,
        ours,
        BEFORE_S,
        "CPU-s",
        15.0,
        False,
        "time of the version before (486 s, a fit for each path) over ours",
        f"{N_PATHS} made paths, {N_EVENTS} events, the whole use case; paths are held out by "
        f"{fits[0]} fits.",
    )
