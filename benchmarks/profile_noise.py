"""Does an error of the profile's points pass for physics?

.venv/bin/python benchmarks/profile_noise.py                    every case, one world each
.venv/bin/python benchmarks/profile_noise.py --sigma 5 --spacing 10 --benched --seeds 4

A line of JSON for each world, in all of which a = 0.5 and no effect is hidden: the verdict, the
posterior of a (median, 5 and 95 %), and how many events the block is made to leave its path.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from itertools import product
from pathlib import Path
from typing import Any

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402

from avahazard.criticism.diagnosis.diagnose import diagnose  # noqa: E402
from avahazard.inference.fitting.mode import find_mode  # noqa: E402
from avahazard.inference.likelihood.posterior import Posterior  # noqa: E402
from avahazard.inference.model.observations import build_observations  # noqa: E402
from avahazard.inference.model.specification import Specification  # noqa: E402
from benchmarks.noisy_ground import NoisyPlan, noisy_world  # noqa: E402


def judge(plan: NoisyPlan, named: bool) -> dict[str, Any]:
    """Fit the world as measured, and diagnose it if `named`."""
    began = time.perf_counter()
    records, _ = noisy_world(plan)
    observations = build_observations(records)
    errors = [site.smooth.sigma_m for site in observations.sites]
    line: dict[str, Any] = {
        "seed": plan.seed,
        "benched": plan.benched,
        "spacing_m": plan.spacing_m,
        "sigma_m": plan.sigma_m,
        "told": plan.told,
        "sigma_found_m": [round(float(v), 2) for v in (min(errors), max(errors))],
        "left_in_records": sum(e.left_profile for e in records.events),
    }
    line |= friction(observations)
    if named:
        found = diagnose(observations, Specification(), {})
        best = found.candidates[0] if found.candidates else None
        line |= {
            "verdict": found.verdict,
            "missing": list(found.missing),
            "best": None if best is None else [best.key, round(best.screened.gain, 2)],
        }
    return line | {"seconds": round(time.perf_counter() - began, 1)}


def friction(observations: Any) -> dict[str, Any]:
    """The posterior of a, by the normal at its mode, and whether the truth is in its 99 %."""
    posterior = Posterior(observations, Specification(), ())
    mode = find_mode(posterior)
    slots = [slot.name for slot in posterior.layout.slots]
    k = slots.index(next(name for name in slots if name in ("log a", "a")))
    middle, sd = float(mode.u[k]), float(np.sqrt(mode.covariance[k, k]))
    low, median, high = np.exp(middle + sd * np.array([-1.645, 0.0, 1.645]))
    off = (middle - np.log(0.5)) / sd
    return {"a": [round(float(v), 3) for v in (low, median, high)], "off_sd": round(off, 2)}


def main() -> None:
    """Print a line for each world."""
    parser = argparse.ArgumentParser(description="Errors of the profile, and what they pass for.")
    parser.add_argument("--sigma", type=float, nargs="*", default=[1.0, 2.0, 3.0, 5.0])
    parser.add_argument("--spacing", type=float, nargs="*", default=[10.0, 25.0, 50.0])
    parser.add_argument("--benched", action=argparse.BooleanOptionalAction, default=None)
    parser.add_argument("--told", action="store_true", help="elevation_sigma_m is given")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--fit-only", action="store_true", help="no diagnosis")
    given = parser.parse_args()
    grounds = (False, True) if given.benched is None else (given.benched,)
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    for seed, benched, spacing, sigma in product(seeds, grounds, given.spacing, given.sigma):
        plan = NoisyPlan(seed, benched, spacing, sigma, given.told)
        print(json.dumps(judge(plan, not given.fit_only)), flush=True)


if __name__ == "__main__":
    main()
