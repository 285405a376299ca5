"""Judge a spread of the synthetic datasets of `worlds.py` again: names before and after, by arm.

… benchmarks/worlds_names.py             judge what today's code has not judged yet
… benchmarks/worlds_names.py --table     only the table

Names before are those of worlds_again.jsonl and, for traps, of worlds_final.jsonl. Those of today
are kept in worlds_names.jsonl: remove it to begin anew.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from avahazard.criticism.diagnosis.diagnose import diagnose  # noqa: E402
from avahazard.inference.model.specification import Specification  # noqa: E402
from benchmarks.study import lines  # noqa: E402
from benchmarks.worlds.arms import Plan, final_worlds, plans  # noqa: E402
from benchmarks.worlds.counts import alarm, in_set  # noqa: E402
from benchmarks.worlds.judging import world  # noqa: E402
from benchmarks.worlds.trap_tables import is_trapped  # noqa: E402

KEPT = HERE / "worlds_names.jsonl"
SIZE = 10
EACH_TRAP = 3
Line = dict[str, Any]


def before() -> dict[str, Line]:
    """Lines of the version before, by the name of the dataset."""
    again = [x for x in lines(HERE / "worlds_again.jsonl") if not is_trapped(x)]
    final = [x for x in lines(HERE / "worlds_final.jsonl") if is_trapped(x)]
    return {x["name"]: x for x in again + final}


def chosen(earlier: dict[str, Line]) -> list[Plan]:
    """Datasets that were judged before, in rounds of all arms, few events first; of a trap three.

    A round goes through every second arm, then the others: what is cut short has seen all kinds.
    """
    made = [p for p in plans(SIZE) if not is_trapped({"arm": p.arm})]
    made += [p for p in final_worlds(SIZE) if is_trapped({"arm": p.arm})]
    arms: dict[str, list[Plan]] = {}
    for plan in sorted(made, key=lambda p: (p.n_events, p.index)):
        if plan.name in earlier:
            arms.setdefault(plan.arm, []).append(plan)
    of = [[*a[:EACH_TRAP]] if is_trapped({"arm": a[0].arm}) else a for a in arms.values()]
    rounds = zip_longest(*of[::2], *of[1::2])
    return [plan for turn in rounds for plan in turn if plan is not None]


def judge(plan: Plan) -> Line:
    """What is named for a dataset, and the CPU-s of the diagnosis."""
    observations = world(plan)
    base = Specification(centrifugal="centrifugal" not in plan.effects)
    began = time.process_time()
    found = diagnose(observations, base, {})
    return {
        "name": plan.name,
        "arm": plan.arm,
        "seed": plan.seed,
        "verdict": found.verdict,
        "missing": list(found.missing),
        "seconds": round(time.process_time() - began, 1),
    }


def table(judged: Sequence[Plan], earlier: dict[str, Line], now: dict[str, Line]) -> list[str]:
    """Counts of each arm before and after, then each dataset whose names differ."""
    rows = ["arm: datasets | right, wrong, missed, CPU-s before | the same after"]
    for arm in (*dict.fromkeys(p.arm for p in judged), ""):
        mine = [p for p in judged if arm in ("", p.arm)]
        sums = ["  ".join(f"{x:5.0f}" for x in counts(mine, of)) for of in (earlier, now)]
        rows.append(f"{arm or 'all':40s} {len(mine):4d} | {' | '.join(sums)}")
    for plan in judged:
        then, today = earlier[plan.name]["missing"], now[plan.name]["missing"]
        if set(then) != set(today):
            rows.append(f"{plan.name}: {then} is now {today}")
    return rows


def counts(mine: Sequence[Plan], of: dict[str, Line]) -> tuple[float, ...]:
    """How many are right (a true effect is named, or nothing false where none is), named wrongly,
    and missed; CPU-s."""
    asked = [of[p.name] | {"true": p.true, "neutral": p.neutral} for p in mine]
    wrong = sum(alarm(x) for x in asked)
    right = sum(in_set(x) if x["true"] else not alarm(x) for x in asked)
    return right, wrong, len(asked) - right - wrong, sum(x["seconds"] for x in asked)


def main() -> None:
    """Judge what is left, then print the table."""
    parser = argparse.ArgumentParser(description="Names before and after a change.")
    parser.add_argument("--table", action="store_true", help="judge nothing")
    given = parser.parse_args()
    earlier = before()
    now = {x["name"]: x for x in lines(KEPT)}
    asked = chosen(earlier)
    for plan in [] if given.table else asked:
        if plan.name not in now:
            now[plan.name] = judge(plan)
            with KEPT.open("a", encoding="utf-8") as file:
                file.write(json.dumps(now[plan.name]) + "\n")
            print(json.dumps(now[plan.name]), flush=True)
    print("\n".join(table([p for p in asked if p.name in now], earlier, now)))


if __name__ == "__main__":
    main()
