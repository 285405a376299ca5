"""Changes of the code, and which of them the tests see, counted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.trust.amounts import Amounts, Tell
from benchmarks.trust.code_changes import Change
from benchmarks.trust.code_mutants import (
    ELSEWHERE,
    TESTED,
    all_changes,
    covered,
    sampled,
    tried,
)

KILLED = ("killed", "too long", "died")


def code(amounts: Amounts, _folder: Path, tell: Tell) -> dict[str, Any]:
    """Try a sample of all small changes of what computes: on the tests of their part, and those
    that these do not see, but for kernels, on those of what stands on the parts."""
    changes = all_changes()
    chosen = sampled(changes, amounts.changes, np.random.default_rng(amounts.seed))
    found: dict[Change, str] = {}
    for compiled, where in ((False, ()), (True, ()), (True, ELSEWHERE)):
        mine = [c for c in chosen if c.compiled is not compiled and found.get(c) not in KILLED]
        if not mine:
            continue
        tests = covered(where, compiled=compiled)
        tell(f"{len(tests.seconds)} tests in {sum(tests.seconds.values()):.0f} s of CPU")
        for change, ended, cpu in tried(mine, tests, compiled=compiled):
            tell(f"{ended} ({cpu:.0f} s): {change.module}:{change.line} {change.what}")
            if ended != "no test" or change not in found:
                found[change] = ended
    return counted(changes, list(found.items()))


def counted(changes: Sequence[Change], found: Sequence[tuple[Change, str]]) -> dict[str, Any]:
    """What is kept of changes that were tried, with how each ended."""
    rows = []
    for name, (folder, _) in TESTED.items():
        ends = [ended for change, ended in found if change.module.startswith(f"{folder}/")]
        rows.append(
            {
                "part": name,
                "changes": sum(change.module.startswith(f"{folder}/") for change in changes),
                "tried": len(ends),
                "killed": sum(ended in KILLED for ended in ends),
                "too long": ends.count("too long"),
            }
        )
    survivors = [
        {
            "place": f"{change.module}:{change.line}",
            "where": change.where,
            "what": change.what,
            "ended": ended,
        }
        for change, ended in found
        if ended not in KILLED
    ]
    return {"rows": rows, "survivors": survivors}
