"""Tables of the worlds with a trap in them: what is named falsely, and what is found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scipy.stats import beta

from benchmarks.worlds.arms import TRAPPED, TRAPS
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, share

Line = dict[str, Any]


def null_arm(trap: str) -> str:
    """The arm of a trap in which nothing is missing."""
    return f"null: {trap}"


def effect_arm(trap: str) -> str:
    """The arm of a trap with an effect in it."""
    return f"trap: {trap} + {TRAPPED}"


def is_trapped(line: Line) -> bool:
    """Whether there is a trap in the world."""
    return line["arm"] in {arm(trap) for trap in TRAPS for arm in (null_arm, effect_arm)}


def interval(k: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share of which k of n were seen (Clopper and Pearson 1934)."""
    low = 0.0 if k == 0 else float(beta.ppf(0.025, k, n - k + 1))
    high = 1.0 if k == n else float(beta.ppf(0.975, k + 1, n - k))
    return low, high


def trap_tables(lines: Sequence[Line]) -> list[str]:
    """A row for every trap, and one for all; what was named falsely, world by world."""
    nulls = [x for x in lines if not x["true"]]
    found = [x for x in lines if x["true"]]
    rows = [
        "| trap | nothing missing: false names | 95 % interval | "
        f"{TRAPPED}: in the set | 95 % interval | alone and first |",
        "|---|---|---|---|---|---|",
    ]
    for trap in TRAPS:
        of_nulls = [x for x in nulls if x["arm"] == null_arm(trap)]
        of_found = [x for x in found if x["arm"] == effect_arm(trap)]
        if of_nulls or of_found:
            rows.append(_row(trap, of_nulls, of_found))
    rows.append(_row("all", nulls, found))
    told = [
        f"- {x['name']}: `{x['verdict']}`, {', '.join(x['missing']) or 'nothing'}"
        for x in lines
        if alarm(x) or (x["true"] and x.get("oracle_gain", 0.0) > SEEN and not in_set(x))
    ]
    return [*rows, "", "Named falsely, or not found:" if told else "None failed.", "", *told]


def _row(trap: str, nulls: list[Line], found: list[Line]) -> str:
    seen = [x for x in found if x.get("oracle_gain", 0.0) > SEEN]
    cells = (
        trap,
        share(nulls, alarm),
        _interval(nulls, alarm),
        share(seen, in_set),
        _interval(seen, in_set),
        share(seen, first_alone),
    )
    return f"| {' | '.join(cells)} |"


def _interval(lines: list[Line], is_so) -> str:  # type: ignore[no-untyped-def]
    if not lines:
        return "-"
    low, high = interval(sum(bool(is_so(x)) for x in lines), len(lines))
    return f"{100.0 * low:.0f} to {100.0 * high:.0f} %"
