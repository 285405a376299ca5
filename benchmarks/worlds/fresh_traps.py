"""Section of docs/worlds.md: traps, and limits of sight, with seeds on which no rule was made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.worlds.arms import FINAL_EFFECT
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, share
from benchmarks.worlds.trap_tables import interval, is_trapped, trap_tables

Line = dict[str, Any]

FINAL = (
    "With seeds from 800,000 on (`SIZE=20 benchmarks/worlds.py --final` and `--further`), most of",
    "them nulls of volume errors and worlds of limits of sight, as settled beforehand; of other",
    "traps the first worlds alone:",
)


SETTLED = (
    "So this was settled, and committed, before any of these worlds was made: 40 more of them, of",
    "seeds from 950,000 on, are judged by what who is told the limits gains; where that is over",
    f"{SEEN:.0f} nats, 9 in 10 are asked for (`SIZE=20 benchmarks/worlds.py --settled`).",
)


def fresh_traps(final: Sequence[Line], settled: Sequence[Line]) -> list[str]:
    """The traps, the effect made with their seeds too, and `settled`, more of that effect."""
    made_too = [x for x in final if x["true"] == [FINAL_EFFECT]]
    told = (
        "fixed beforehand; the other was thought of after 18 of the 40 worlds had been looked at."
    )
    return [
        *FINAL,
        "",
        *trap_tables([x for x in final if is_trapped(x)]),
        "",
        *_found(made_too),
        *(_by_estimate(made_too, told) if made_too else ()),
        "",
        *SETTLED,
        "",
        *_found(settled),
        *(_by_estimate(settled, "that fixed for the 40 worlds before these.") if settled else ()),
    ]


def _found(lines: Sequence[Line]) -> list[str]:
    """How often the effect is found where who is told the limits gains enough."""
    seen = [x for x in lines if x["told_gain"] > SEEN]
    if not seen:
        return [f"None yet of `{FINAL_EFFECT}`."]
    low, high = (round(100.0 * v) for v in interval(sum(map(in_set, seen)), len(seen)))
    others = [x for x in lines if x not in seen]
    wrong = share(lines, lambda x: alarm(x) and len(x["missing"]) == 1)
    missed = [f"{x['name']} ({x['told_gain']:.1f})" for x in seen if not in_set(x)]
    return [
        f"`{FINAL_EFFECT}`, undeclared, of full and half strength, {len(lines)} worlds: in the set",
        f"in {share(seen, in_set)}, {low} to {high} %, where who is told the limits gains over",
        f"{SEEN:.0f} nats; alone in {share(seen, first_alone)}. Where that is less, in",
        f"{share(others, in_set)}. Something else alone in {wrong}. Missed, and what is gained:",
        f"{', '.join(missed) or 'none'}.",
    ]


def _by_estimate(lines: Sequence[Line], told: str) -> list[str]:
    """The same where the limits are estimated, and what that measure is."""
    fitted = [x for x in lines if x["oracle_gain"] > SEEN]
    return [
        "Elsewhere on this page an oracle estimates the limits, which gains by chance as well:",
        f"where that is over {SEEN:.0f} nats, {share(fitted, in_set)} are in the set. That measure",
        f"was {told}",
    ]
