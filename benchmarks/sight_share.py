"""How the test of limits of sight hangs on the share of them that is taken for chance.

Worlds in which short runouts were not seen, and of which nothing was declared, and worlds in which
all were; of each the rank of the gain among 199 made worlds, less a share of what the limit gains
by chance (`criticism/screening/limit_by_chance.py`). Prints how many come under each level.

.venv/bin/python benchmarks/sight_share.py       all worlds; some ten minutes
… benchmarks/sight_share.py --worlds 20          so many of each kind
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from avahazard.criticism.diagnosis.nuisances import (  # noqa: E402
    with_nuisances_granted,
    with_tails_granted,
)
from avahazard.criticism.diagnosis.refits import without_groups  # noqa: E402
from avahazard.criticism.screening.chance_gains import gains_by_chance  # noqa: E402
from avahazard.criticism.screening.tested_model import tested_model  # noqa: E402
from avahazard.inference.likelihood.assemble import find_definition  # noqa: E402
from avahazard.inference.model.specification import Specification  # noqa: E402
from avahazard.synth.settings import Settings  # noqa: E402
from benchmarks.worlds.arms import LARGE, SMALL, TRAPS, Plan  # noqa: E402
from benchmarks.worlds.judging import world  # noqa: E402

KEY = "observation-limit"
FIRST_SEED = 860_000
N_MADE = 199
SHARES = (0.0, 0.5, 1.0)
LEVELS = (0.01, 0.02, 0.05, 0.1)
KINDS: dict[str, dict[str, object]] = {
    "not seen, full strength": {"effects": {KEY: 1.0}},
    "not seen, half": {"effects": {KEY: 0.5}},
    "all seen": {},
    "all seen, volumes err by 1.0 for 0.3": {
        "settings": TRAPS["volume errors"].settings,
        "stated": TRAPS["volume errors"].stated,
    },
    "all seen, paths differ": {"effects": {"path-effect": 1.0}},
    "all seen, heavy tails": {"settings": Settings(student_df=4.0, wrong_share=0.02)},
}


def main() -> None:
    """A row for each kind of world and share."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--worlds", type=int, default=40)
    n_worlds = parser.parse_args().worlds
    print("| worlds | share | " + " | ".join(f"p ≤ {level:g}" for level in LEVELS) + " |")
    print("|---" * (2 + len(LEVELS)) + "|")
    for kind, (name, given) in enumerate(KINDS.items()):
        seeds = range(FIRST_SEED + 1000 * kind, FIRST_SEED + 1000 * kind + n_worlds)
        p = np.array([ranks(seed, given) for seed in seeds])
        for share, of in zip(SHARES, p.T, strict=True):
            under = (f"{np.sum(of <= level + 1e-9)} of {n_worlds}" for level in LEVELS)
            print(f"| {name} | {share:g} | {' | '.join(under)} |", flush=True)


def ranks(seed: int, given: dict[str, object]) -> NDArray[np.float64]:
    """p-values by rank of one world, for each share."""
    n_events, n_paths = SMALL if seed % 2 else LARGE
    observations = world(Plan("", 0, seed, n_events, n_paths, **given))  # type: ignore[arg-type]
    plain = with_tails_granted(observations, Specification(), {}, ())
    base = with_nuisances_granted(observations, plain, ()).base
    bare, u, spreads = without_groups(base, observations, ())
    tested = tested_model(bare, u, spreads, [find_definition(KEY, ())], records_alone=False)
    found = gains_by_chance(tested, 0, range(-1, N_MADE), lambda _share: None, N_MADE)
    gain = np.array([float(w.of_candidates[0]) for w in found])
    limit = np.array([w.beside.limit for w in found])
    return np.array([np.mean((left := gain - share * limit) >= left[0]) for share in SHARES])


if __name__ == "__main__":
    main()
