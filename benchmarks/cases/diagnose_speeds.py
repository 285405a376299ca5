"""`diagnose` on 240 events with speeds along 75 tracks, on two cores."""

from __future__ import annotations

import os

from avahazard.engine import set_engine
from avahazard.inference.model.observations import build_observations
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings
from benchmarks.cases.diagnose import LIMIT_S, diagnosis
from benchmarks.measuring import Result, seconds

SHARE = 75 / 240


def measure() -> Result:
    """Seconds of a diagnosis by a process for each core, once these have compiled."""
    one_core = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") else None
    if one_core is not None:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    settings = Settings(speeds=SHARE)
    small = build_observations(make_world(72, 40, 4, {"turbulent-drag": 1.0}, settings)[0])
    observations = build_observations(make_world(71, 240, 9, {"turbulent-drag": 1.0}, settings)[0])
    set_engine("processes")
    diagnosis(small)  # compiles
    ours = seconds(lambda: diagnosis(observations))
    set_engine("local")  # ends the processes
    if one_core is not None:
        os.sched_setaffinity(0, one_core)
    n = [len(m.x) for m in observations.speeds]
    return Result(
        ours / LIMIT_S,
        ours,
        LIMIT_S,
        "s per diagnosis",
        1.0,
        True,
        "time of a diagnosis over a minute",
        f"240 events on 9 paths, hidden drag, {len(n)} tracks of {sum(n) / len(n):.0f} speeds, at "
        f"most 199 made worlds, `--engine processes` on {os.cpu_count()} cores. Theirs is the "
        "limit.",
    )
