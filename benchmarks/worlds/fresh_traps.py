"""Section of docs/worlds.md: traps, and limits of sight, with seeds on which no rule was made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.worlds.arms import FINAL_EFFECT, FURTHER, N_FURTHER
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, share
from benchmarks.worlds.trap_tables import interval, is_trapped, trap_tables

Line = dict[str, Any]

FINAL = (
    "Written by `SIZE=20 benchmarks/worlds.py --final` and `--further`, by one version, that of 25",
    "November, after all of the above; no rule was changed since. Nothing of these worlds was",
    f"looked at before. {N_FURTHER} more nulls of {FURTHER} were settled beforehand: an earlier",
    "version, on other fresh seeds, had named 13 of 450 nulls falsely (3 %) and found all of 163",
    "effects, but named 11 of 150 nulls of that trap (7 %). Three of these 11 were smooths of a",
    "deposit's length, which led to a rule: such a smooth must lead by 3 nats where errors of",
    "volumes may be misstated.",
)


def fresh_traps(final: Sequence[Line]) -> list[str]:
    """The traps, and the effect that is made with these seeds too."""
    return [
        *FINAL,
        "",
        *trap_tables([x for x in final if is_trapped(x)]),
        "",
        *_found([x for x in final if x["true"] == [FINAL_EFFECT]]),
    ]


def _found(lines: Sequence[Line]) -> list[str]:
    """How often the effect is found where who is told the limits gains enough."""
    seen = [x for x in lines if x["told_gain"] > SEEN]
    if not seen:
        return [f"None yet of `{FINAL_EFFECT}`."]
    low, high = (round(100.0 * v) for v in interval(sum(map(in_set, seen)), len(seen)))
    others = [x for x in lines if x not in seen]
    wrong = share(lines, lambda x: alarm(x) and len(x["missing"]) == 1)
    fitted = [x for x in lines if x["oracle_gain"] > SEEN]
    missed = [f"{x['name']} ({x['told_gain']:.0f})" for x in seen if not in_set(x)]
    enough = f"{SEEN:.0f} nats"
    return [
        f"`{FINAL_EFFECT}`, undeclared, of full and half strength, {len(lines)} worlds: in the set",
        f"in {share(seen, in_set)}, {low} to {high} %, where who is told the limits gains over",
        f"{enough}; alone in {share(seen, first_alone)}. Where that is less, in",
        f"{share(others, in_set)}. Something else alone in {wrong}. Missed, and what is gained:",
        f"{', '.join(missed) or 'none'}.",
        "Elsewhere on this page an oracle estimates the limits, which gains by chance as well:",
        f"where that is over {enough}, {share(fitted, in_set)} are in the set.",
    ]
