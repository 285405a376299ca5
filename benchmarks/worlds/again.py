"""The same worlds with today's version: one of every arm, and what came out differently."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.worlds.arms import Plan
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, share
from benchmarks.worlds.trap_tables import is_trapped

Line = dict[str, Any]
ALL_OF = "observation-limit x"
"""Arms that are gone through whole."""


def one_of_each(plans: Sequence[Plan]) -> list[Plan]:
    """The first odd world of every arm (120 events; the first where none is odd), without traps.

    Of `ALL_OF` all.
    """
    chosen: dict[str, Plan] = {}
    for plan in sorted(plans, key=lambda p: (p.index % 2 == 0, p.index)):
        if not is_trapped({"arm": plan.arm}):
            chosen.setdefault(plan.arm, plan)
    return [p for p in plans if chosen.get(p.arm) is p or p.arm.startswith(ALL_OF)]


def comparison(before: Sequence[Line], after: Sequence[Line]) -> list[str]:
    """Shares of the worlds of both, and each that is told otherwise now."""
    earlier = {x["name"]: x for x in before}
    pairs = [(earlier[x["name"]], x) for x in after if x["name"] in earlier]
    if not pairs:
        return ["None yet."]
    nulls = [p for p in pairs if not p[0]["true"]]
    effects = [p for p in pairs if p[0]["true"]]
    seen = [p for p in effects if p[0].get("oracle_gain", 0.0) > SEEN]
    unseen = [p for p in seen if p[0]["arm"].startswith(ALL_OF)]
    rows = [
        ("false alarms where nothing is missing", nulls, alarm),
        ("right effect named or in the set", effects, in_set),
        ("named alone and first", effects, first_alone),
        (f"in the set where it gains over {SEEN:.0f} nats", seen, in_set),
        ("… of these `observation-limit`", unseen, in_set),
        ("a wrong name alone", effects, lambda x: alarm(x) and len(x["missing"]) == 1),
    ]
    changed = [p for p in pairs if sorted(p[0]["missing"]) != sorted(p[1]["missing"])]
    return [
        "| what | then | now |",
        "|---|---|---|",
        *(
            f"| {what} | {share([p[0] for p in of], so)} | {share([p[1] for p in of], so)} |"
            for what, of, so in rows
        ),
        "",
        f"Told otherwise, {len(changed)} of {len(pairs)}"
        + (" (oracle: what the true effect gains, in nats):" if changed else "."),
        *([""] if changed else []),
        *(
            f"- {x['name']}: {_told(y)}; then {_told(x)}"
            + (f" (oracle {y['oracle_gain']:.0f})" if "oracle_gain" in y else "")
            for x, y in changed
        ),
    ]


def _told(line: Line) -> str:
    return ", ".join(f"`{key}`" for key in line["missing"]) or f"{line['verdict']}, nothing named"
