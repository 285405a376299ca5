"""`diagnose` on 240 events of 9 paths, all candidates, 199 made worlds, on two cores."""

from __future__ import annotations

import os
from statistics import median

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings
from benchmarks.measuring import Result, seconds

LIMIT_S = 60.0
WORLDS = {
    "season": ({"season": 1.0}, Settings()),
    "drag, speeds": ({"turbulent-drag": 1.0}, Settings(speeds=0.2)),
    "nothing missing": ({}, Settings()),
}


def measure() -> Result:
    """Seconds of a diagnosis, once compiled."""
    one_core = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") else None
    if one_core is not None:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    found = {}
    for k, (name, (effects, settings)) in enumerate(WORLDS.items()):
        observations = build_observations(make_world(70 + k, 240, 9, effects, settings)[0])
        diagnosis(observations)  # compiles
        found[name] = seconds(lambda observations=observations: diagnosis(observations))  # type: ignore[misc]
    if one_core is not None:
        os.sched_setaffinity(0, one_core)
    typical = median(found.values())
    times = ", ".join(f"{name} {time:.0f} s" for name, time in found.items())
    return Result(
        typical / LIMIT_S,
        typical,
        LIMIT_S,
        "s per diagnosis",
        1.0,
        True,
        "time of a diagnosis over a minute",
        f"240 events on 9 paths, 199 made worlds (fewer where nothing is missing): {times}. "
        "Theirs is the limit: nobody else offers it.",
    )


def diagnosis(observations: Observations) -> object:
    """What the command computes."""
    return diagnose(observations, Specification(), {}, n_worlds=199)
