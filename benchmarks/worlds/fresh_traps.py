"""Section of docs/worlds.md: the traps with seeds on which no rule was made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.worlds.arms import FURTHER, N_FURTHER, further_nulls
from benchmarks.worlds.counts import alarm, share
from benchmarks.worlds.trap_tables import interval, null_arm, trap_tables

Line = dict[str, Any]

FINAL = (
    "Written by `SIZE=20 benchmarks/worlds.py --final`, by one version, that of 24 November, after",
    "all of the above; no rule was changed since. Nothing of these worlds was looked at before.",
    "The first 365 of the 630 were looked at before the others ran, which changed nothing.",
)


FURTHER_TOLD = (
    "In two of these traps 4 of 50 nulls are named falsely, which is more than 5 %, and may be",
    f"chance. So {N_FURTHER} more of each were run with the same version (`benchmarks/worlds.py",
    "--further`), as was settled before any of them was made:",
)


def fresh_traps(final: Sequence[Line]) -> list[str]:
    """The final traps, the further nulls, and both together."""
    names = {plan.name for plan in further_nulls()}
    further = [x for x in final if x["name"] in names]
    return [
        *FINAL,
        "",
        *trap_tables([x for x in final if x not in further]),
        "",
        *FURTHER_TOLD,
        "",
        *trap_tables(further),
        "",
        *_together(final),
    ]


def _together(final: Sequence[Line]) -> list[str]:
    """All fresh nulls of the traps of which more were run."""
    told = []
    for trap in FURTHER:
        nulls = [x for x in final if x["arm"] == null_arm(trap)]
        low, high = interval(sum(map(alarm, nulls)), len(nulls))
        told.append(f"{trap} {share(nulls, alarm)}, {100 * low:.0f} to {100 * high:.0f} %")
    return [f"With the 50 before them: {'; '.join(told)}."]
