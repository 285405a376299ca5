"""What the intervals of the 100-year runout cover; writes docs/coverage.md.

make coverage                              WORLDS=200 worlds, HARDER=60 of each harder kind
… benchmarks/coverage.py --minutes 10      stop after ten minutes; the next run goes on from there
… benchmarks/coverage.py --part 1/2        every second world, for a second process
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.coverage_study.arms import ARMS, PLAIN  # noqa: E402
from benchmarks.coverage_study.judging import FAMILIES, judge  # noqa: E402
from benchmarks.coverage_study.page import page  # noqa: E402
from benchmarks.finished import finished  # noqa: E402

FIRST_HARDER = 401


def main() -> None:
    """Go through the worlds that are not in the results yet; write the page."""
    given = arguments()
    done = {(line.get("arm", PLAIN), line["seed"]) for line in finished(given.results)}
    until = time.monotonic() + 60.0 * given.minutes
    k, n = (int(v) for v in given.part.split("/"))
    for arm, seed in planned(given.worlds, given.harder)[k - 1 :: n]:
        if time.monotonic() > until:
            break
        if (arm, seed) in done:
            continue
        line = judge(ARMS[arm](seed), FAMILIES if arm == PLAIN else FAMILIES[:1])
        with given.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"arm": arm, **line}) + "\n")
        print(f"{arm}, world {seed}: {line['seconds']:.0f} s", flush=True)
    lines = finished(given.results)
    command = f"make coverage WORLDS={given.worlds} HARDER={given.harder}"
    given.page.write_text(page(lines, command), encoding="utf-8")


def planned(n_plain: int, n_harder: int) -> list[tuple[str, int]]:
    """Every arm with its worlds by seed. Those of the harder arms have not been looked at."""
    worlds = [(PLAIN, seed) for seed in range(1, n_plain + 1)]
    harder = range(FIRST_HARDER, FIRST_HARDER + n_harder)
    return worlds + [(arm, seed) for seed in harder for arm in ARMS if arm != PLAIN]


def arguments() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="Coverage of the 100-year runout.")
    parser.add_argument("--worlds", type=int, default=int(os.environ.get("WORLDS", "200")))
    parser.add_argument("--harder", type=int, default=int(os.environ.get("HARDER", "60")))
    parser.add_argument("--part", default="1/1", metavar="K/N")
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--results", type=Path, default=HERE / "coverage.jsonl")
    parser.add_argument("--page", type=Path, default=HERE.parent / "docs" / "coverage.md")
    return parser.parse_args()


if __name__ == "__main__":
    main()
