"""docs/worlds.md from the lines of results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

Line = dict[str, Any]
SEEN = 10.0
"""Gain (nats) over which an oracle detects an effect."""


def page(lines: Sequence[Line], command: str, n_planned: int) -> str:
    """The page: what must hold, then every arm."""
    nulls = [x for x in lines if not x["true"] and x["arm"].startswith("null")]
    alone = [x for x in lines if x["true"] and ":" not in x["arm"].replace("covariate:", "")]
    seen = [x for x in alone if x["n_events"] >= 200 and x.get("oracle_gain", 0.0) > SEEN]
    parts = [
        "# Worlds with a known truth",
        "",
        f"Written by `{command}`: {len(lines)} of {n_planned} worlds, whose seeds stand in",
        "`benchmarks/worlds/arms.py` (a run that was cut short goes on). They are made by an",
        "integrator of their own, not by the product's. Counts stand beside every share; few say",
        "little.",
        "",
        "The level and the evidence that a name takes, and what counts as a false alarm, were",
        "settled after a look at the first 10 to 20 nulls of each arm, which are in these tables:",
        "of the nulls, the later ones alone are a fair test.",
        "",
        "## What must hold",
        "",
        "| what | is | must be |",
        "|---|---|---|",
        *_requirements(nulls, seen, lines),
        "",
        "## Nulls: false alarms",
        "",
        "An alarm is false if nothing that it names is in the world: not where paths differ and",
        "the path effect is named, nor where scatter falls with volume and that is in the set.",
        "",
        *_table(
            nulls,
            {
                "false alarms": lambda x: _share(x, alarm),
                "of best BIC": lambda x: _share(x, lambda w: _rival_alarm(w, "bic")),
                "of regression": lambda x: _share(x, lambda w: _rival_alarm(w, "regression")),
                "coverage of 90 %": lambda x: _mean(x, lambda w: w["base"][1]),
            },
        ),
        "",
        "## Effects",
        "",
        f"Worlds in which an oracle gains over {SEEN:g} nats; in brackets how many there are.",
        "",
        *_effects([x for x in lines if x["true"]]),
        "",
        "## A wrong effect added",
        "",
        *_wrong([x for x in lines if "wrong" in x]),
        "",
    ]
    return "\n".join(parts)


def alarm(x: Line) -> bool:
    """Whether something is named, and nothing that is true or harmless with it."""
    return bool(x["missing"]) and not set(x["missing"]) & {*x["true"], *x["neutral"]}


def in_set(x: Line) -> bool:
    """Whether a true effect is named or in the set."""
    return bool(set(x["missing"]) & set(x["true"]))


def first_alone(x: Line) -> bool:
    """Whether one effect is named, and it is right."""
    return len(x["missing"]) == 1 and x["missing"][0] in x["true"]


def one_named(x: Line) -> bool:
    """Whether one effect is named alone."""
    return len(x["missing"]) == 1


def _rival_alarm(x: Line, who: str) -> bool:
    return x[who] is not None and x[who] not in (*x["true"], *x["neutral"])


def _right(who: str) -> Callable[[Line], bool]:
    return lambda x: x[who] in x["true"]


def _requirements(nulls: list[Line], seen: list[Line], lines: Sequence[Line]) -> list[str]:
    single = [x for x in seen if one_named(x)]
    outside = [
        x for x in lines if x["arm"].startswith("outside") and x.get("oracle_gain", 0.0) > SEEN
    ]
    later = [x for x in lines if "with_speeds" in x]
    told = [x for x in lines if "as_told" in x]
    rows = [
        ("right effect named or in the set", _share(seen, in_set), "95 %"),
        ("named alone and first", _share(seen, first_alone), "85 %"),
        ("… by the best BIC", _share(seen, _right("bic")), "clearly less"),
        ("… by a regression", _share(seen, _right("regression")), "clearly less"),
        ("right where one is named alone", _share(single, first_alone), "95 %"),
        ("false alarms, all nulls", _share(nulls, alarm), "at most 7 % on each arm"),
        ("… of the best BIC", _share(nulls, lambda x: _rival_alarm(x, "bic")), ""),
        ("… of a regression", _share(nulls, lambda x: _rival_alarm(x, "regression")), ""),
        ("held-out CRPS over the oracle's, median", _ratio(seen), "at most 1.05"),
        ("coverage of 90 % intervals", _mean(seen, lambda x: x["child"][1]), "87 to 93 %"),
        ("outside: right axis", _share(outside, in_set), "70 %"),
        ("outside: wrong catalogue name", _share(outside, _catalogue_name), "at most 10 %"),
        ("seconds of a diagnosis, median and slowest", _seconds(lines), ""),
        (
            "confounded, once speeds are measured: right one",
            _share(later, lambda x: x["with_speeds"][1] == x["true"]),
            "named",
        ),
        (
            "ambiguous, once what is told is measured: right one",
            _share(told, lambda x: x["as_told"][1] == x["true"]),
            "named",
        ),
    ]
    return [f"| {a} | {b} | {c} |" for a, b, c in rows]


def _catalogue_name(x: Line) -> bool:
    return any(not k.startswith("covariate:") for k in x["missing"])


def _effects(lines: list[Line]) -> list[str]:
    head = (
        "arm", "worlds", "in the set", "alone and first", "something else alone", "best BIC",
        "regression", "CRPS base, child, oracle (m)", "coverage",
    )  # fmt: skip
    rows = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for arm in dict.fromkeys(x["arm"] for x in lines):
        every = [x for x in lines if x["arm"] == arm]
        mine = [x for x in every if x.get("oracle_gain", 0.0) > SEEN]
        rows.append(
            "| "
            + " | ".join(
                (
                    arm,
                    f"{len(mine)} ({len(every)})",
                    _share(mine, in_set),
                    _share(mine, first_alone),
                    _share(mine, lambda x: one_named(x) and not first_alone(x)),
                    _share(mine, _right("bic")),
                    _share(mine, _right("regression")),
                    _crps(mine),
                    _mean(mine, lambda x: x["child"][1]),
                )
            )
            + " |"
        )
    return rows


def _table(lines: list[Line], columns: dict[str, Callable[[list[Line]], str]]) -> list[str]:
    rows = [f"| arm | worlds | {' | '.join(columns)} |", "|---" * (len(columns) + 2) + "|"]
    for arm in dict.fromkeys(x["arm"] for x in lines):
        mine = [x for x in lines if x["arm"] == arm]
        rows.append(f"| {arm} | {len(mine)} | {' | '.join(c(mine) for c in columns.values())} |")
    return rows


def _wrong(lines: list[Line]) -> list[str]:
    if not lines:
        return ["No worlds yet."]
    ratios = [x["wrong"][0] / x["base"][0] for x in lines]
    lower = sum(r < 0.99 for r in ratios)
    return [
        f"Held-out CRPS with a needless effect over that without: median {median(ratios):.3f}; "
        f"lower by more than 1 % in {lower} of {len(lines)} worlds."
    ]


def _share(lines: Sequence[Line], is_so: Callable[[Line], bool]) -> str:
    if not lines:
        return "-"
    n = sum(bool(is_so(x)) for x in lines)
    return f"{100.0 * n / len(lines):.0f} % ({n}/{len(lines)})"


def _mean(lines: Sequence[Line], value: Callable[[Line], float]) -> str:
    if not lines:
        return "-"
    return f"{100.0 * sum(value(x) for x in lines) / len(lines):.0f} %"


def _ratio(lines: Sequence[Line]) -> str:
    ratios = [x["child"][0] / x["oracle"][0] for x in lines if "oracle" in x]
    return f"{median(ratios):.3f} ({len(ratios)} worlds)" if ratios else "-"


def _seconds(lines: Sequence[Line]) -> str:
    times = [x["seconds"] for x in lines]
    return f"{median(times):.0f}, {max(times):.0f}"


def _crps(lines: Sequence[Line]) -> str:
    kept = [x for x in lines if "oracle" in x]
    if not kept:
        return "-"
    return ", ".join(f"{median(x[k][0] for x in kept):.1f}" for k in ("base", "child", "oracle"))
