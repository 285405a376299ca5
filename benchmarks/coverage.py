"""What the intervals of the 100-year runout cover; writes docs/coverage.md.

make coverage                              WORLDS=200 worlds
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

from benchmarks.coverage_study.judging import judge  # noqa: E402
from benchmarks.coverage_study.page import page  # noqa: E402
from benchmarks.coverage_study.world import true_world  # noqa: E402
from benchmarks.finished import finished  # noqa: E402


def main() -> None:
    """Go through the worlds that are not in the results yet; write the page."""
    given = arguments()
    done = {line["seed"] for line in finished(given.results)}
    until = time.monotonic() + 60.0 * given.minutes
    k, n = (int(v) for v in given.part.split("/"))
    for seed in range(k, given.worlds + 1, n):
        if time.monotonic() > until:
            break
        if seed in done:
            continue
        line = judge(true_world(seed))
        with given.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        print(f"world {seed} of {given.worlds}: {line['seconds']:.0f} s", flush=True)
    lines = finished(given.results)
    given.page.write_text(page(lines, f"make coverage WORLDS={given.worlds}"), encoding="utf-8")


def arguments() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="Coverage of the 100-year runout.")
    parser.add_argument("--worlds", type=int, default=int(os.environ.get("WORLDS", "200")))
    parser.add_argument("--part", default="1/1", metavar="K/N")
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--results", type=Path, default=HERE / "coverage.jsonl")
    parser.add_argument("--page", type=Path, default=HERE.parent / "docs" / "coverage.md")
    return parser.parse_args()


if __name__ == "__main__":
    main()
