"""Diagnose worlds whose truth is known; write docs/worlds.md.

make worlds                 SIZE=10 worlds of each effect and strength, and more of the nulls
… benchmarks/worlds.py --minutes 60      stop after an hour; the next run goes on from there
… benchmarks/worlds.py --part 1/2        every second world, for a second machine
… benchmarks/worlds.py --arm snow-type   only arms with that in their name
… benchmarks/worlds.py --traps           only arms with a trap
… benchmarks/worlds.py --again           one world of each arm again, with today's version
… benchmarks/worlds.py --final           traps, limits of sight: seeds on which no rule was made
… benchmarks/worlds.py --further         more nulls of these, in the trap that is the hardest
… benchmarks/worlds.py --settled         limits of sight, judged by who is told them
… benchmarks/worlds.py arms              names of the arms beyond the catalogue, one a line
… benchmarks/worlds.py make ARM SEED FOLDER    a dataset of such an arm, as CSV, with its truth
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
HERE = Path(__file__).resolve().parent
AGAIN = HERE / "worlds_again.jsonl"
FINAL = HERE / "worlds_final.jsonl"
SETTLED = HERE / "worlds_settled.jsonl"
sys.path.insert(0, str(HERE.parent))

from benchmarks.study import keep, lines  # noqa: E402
from benchmarks.worlds import beyond  # noqa: E402
from benchmarks.worlds.again import one_of_each  # noqa: E402
from benchmarks.worlds.arms import final_worlds, further_nulls, plans, settled_worlds  # noqa: E402
from benchmarks.worlds.judging import judge  # noqa: E402
from benchmarks.worlds.page import page  # noqa: E402
from benchmarks.worlds.trap_tables import is_trapped  # noqa: E402


def main() -> None:
    """Go through the worlds that are not in the results yet; write the page."""
    given = arguments()
    size = int(os.environ.get("SIZE", "10"))
    results, made = given.results, plans(size)
    if given.again:
        results = AGAIN
    elif given.final:
        results, made = FINAL, final_worlds(size)
    elif given.further:
        results, made = FINAL, further_nulls()
    elif given.settled:
        results, made = SETTLED, settled_worlds(size)
    done = {x["name"]: x for x in lines(results)}
    k, n = (int(v) for v in given.part.split("/"))
    chosen = [p for p in made[k - 1 :: n] if given.arm in p.arm]
    if given.traps:
        chosen = [p for p in chosen if is_trapped({"arm": p.arm})]
    if given.again:
        chosen = one_of_each(chosen)
    until = time.monotonic() + 60.0 * given.minutes
    for plan in chosen:
        if time.monotonic() > until:
            break
        if plan.name in done:
            continue
        line = judge(plan)
        done[plan.name] = line
        keep(results, line)
        print(
            f"{sum(p.name in done for p in chosen)}/{len(chosen)}  {plan.name}: {line['verdict']} "
            f"{', '.join(line['missing'])} ({line['all_seconds']:.0f} s)",
            flush=True,
        )
    if given.page:
        command = f"make worlds SIZE={size}"
        others = [lines(file) for file in (AGAIN, FINAL, SETTLED)]
        given.page.write_text(
            page(lines(given.results), command, len(plans(size)), *others),
            encoding="utf-8",
        )


def arguments() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="Benchmark of worlds with a known truth.")
    parser.add_argument("--part", default="1/1", metavar="K/N")
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--arm", default="", help="only arms with this in their name")
    parser.add_argument("--traps", action="store_true", help="only arms with a trap")
    parser.add_argument("--again", action="store_true", help="one world of each arm again")
    parser.add_argument("--final", action="store_true", help="the traps with seeds of their own")
    parser.add_argument("--further", action="store_true", help="more nulls of two of these")
    parser.add_argument("--settled", action="store_true", help="limits of sight, by who knows them")
    parser.add_argument("--results", type=Path, default=HERE / "worlds.jsonl.gz")
    parser.add_argument("--page", type=Path, default=HERE.parent / "docs" / "worlds.md")
    return parser.parse_args()


if __name__ == "__main__":
    if sys.argv[1:2] in (["arms"], ["make"]):
        beyond.command(sys.argv[1:])
    else:
        main()
