"""docs/worlds.md from the lines of results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

from benchmarks.worlds.again import comparison
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, one_named, share
from benchmarks.worlds.fresh_traps import fresh_traps
from benchmarks.worlds.trap_tables import is_trapped, trap_tables

Line = dict[str, Any]


EARLIER = (
    "All that follows is of an earlier version, of 21 November 2026, with 99 made worlds a",
    "diagnosis: before winters, storms and pairs were looked for, and before the levels of all",
    "that is tested added up to 5 %. Its level, the evidence that a name takes, and what counts as",
    "a false alarm were settled after a look at the first 10 to 20 nulls of each arm, which are in",
    "these tables: of the nulls, the later ones alone are a fair test.",
)


CHANGED = (
    "The arms of volume errors, and of 2 and 4 paths, were run again whole on 24 November, with",
    "volumes of a population of their own and moments of records where friction is expected;",
    "declared limits on 23 November, with made worlds that hold what could have been seen. They",
    "stand as they came out, with the seeds of before. The other arms are of the versions of 21 to",
    "23 November.",
    "",
    "Some of the first worlds led to changes of the rules, so that they are no test of these. In",
    "the trap 3 paths with `snow-type`, #0, nothing was named: the effect had 31 nats of evidence,",
    "but a gain of -7 on paths held out, whose records were judged one by one. Judged at once they",
    "gain 32, and it is named. In nulls of volume errors (#0, #3, #6, #9) another law, paths, a",
    "length and the leading edge were named. Another law must now hold beside errors of volumes",
    "that are misstated, and many of which overstate; a length beside errors for which it stands",
    "in, as it goes with the true volume; paths that differ need 3 nats, as all else does. The",
    "worlds of volume errors from #10 on (with `snow-type`, from #4 on) came after this. Of the",
    "other traps the nulls up to #10 and the effects up to #4 ran before it.",
)


def page(
    lines: Sequence[Line],
    command: str,
    n_planned: int,
    again: Sequence[Line],
    final: Sequence[Line],
    settled: Sequence[Line],
) -> str:
    """The page: traps, `final` and `settled` with seeds of their own, what must hold,
    `again` what today's version says, then every arm."""
    trapped = [x for x in lines if is_trapped(x)]
    n_all, lines = len(lines), [x for x in lines if not is_trapped(x)]
    nulls = [x for x in lines if not x["true"] and x["arm"].startswith("null")]
    alone = [x for x in lines if x["true"] and ":" not in x["arm"].replace("covariate:", "")]
    seen = [x for x in alone if x["n_events"] >= 200 and x.get("oracle_gain", 0.0) > SEEN]
    parts = [
        "# Worlds with a known truth",
        "",
        f"Written by `{command}`: {n_all} of {n_planned} worlds, whose seeds stand in",
        "`benchmarks/worlds/arms.py` (a run that was cut short goes on). They are made by an",
        "integrator of their own, not by the product's. Counts stand beside every share; few say",
        "little.",
        "",
        "## Traps",
        "",
        *_traps(trapped),
        "",
        "## Traps, with seeds on which no rule was made",
        "",
        *fresh_traps(final, settled),
        "",
        "## What must hold",
        "",
        *EARLIER,
        "",
        "| what | is | must be |",
        "|---|---|---|",
        *_requirements(nulls, seen, lines),
        "",
        "## The same worlds with today's version",
        "",
        "Written by `benchmarks/worlds.py --again`: of each arm without a trap the first world of",
        "120 events (of the confounded ones the first), whatever an oracle gains in it, and all in",
        "which short runouts were not seen. Such a model has a limit for each path, just above the",
        "highest stop, and so gains by chance as well. Where it is missed with over 10 nats, more",
        "than 1 % of the worlds in which all is seen gain as much, and 1 % is its level.",
        "",
        *comparison(lines, again),
        "",
        "## Nulls: false alarms",
        "",
        "An alarm is false if nothing that it names is in the world: not where paths differ and",
        "the path effect is named, nor where scatter falls with volume and that is in the set.",
        "",
        *_table(
            nulls,
            {
                "false alarms": lambda x: share(x, alarm),
                "of best BIC": lambda x: share(x, lambda w: _rival_alarm(w, "bic")),
                "of regression": lambda x: share(x, lambda w: _rival_alarm(w, "regression")),
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


def _traps(lines: list[Line]) -> list[str]:
    if not lines:
        return ["None yet."]
    return [
        "What real records do and the model does not: storms and winters that share their snow,",
        "two to four paths that differ, misstated and gross errors. With nothing missing, and with",
        "`snow-type` (of full strength, where an oracle gains over 10 nats). A group that differs",
        "is no false name where groups do, nor an error where it is misstated.",
        "",
        "Fixed before the run: seeds (of no world that was looked at before), order, levels, what",
        "counts as false, and up to 199 made worlds, as a user has. The run goes through all arms",
        "in turn.",
        "",
        *CHANGED,
        "",
        *trap_tables(lines),
    ]


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
        ("right effect named or in the set", share(seen, in_set), "95 %"),
        ("named alone and first", share(seen, first_alone), "85 %"),
        ("… by the best BIC", share(seen, _right("bic")), "clearly less"),
        ("… by a regression", share(seen, _right("regression")), "clearly less"),
        ("right where one is named alone", share(single, first_alone), "95 %"),
        ("false alarms, all nulls", share(nulls, alarm), "at most 7 % on each arm"),
        ("… of the best BIC", share(nulls, lambda x: _rival_alarm(x, "bic")), ""),
        ("… of a regression", share(nulls, lambda x: _rival_alarm(x, "regression")), ""),
        ("held-out CRPS over the oracle's, median", _ratio(seen), "at most 1.05"),
        ("coverage of 90 % intervals", _mean(seen, lambda x: x["child"][1]), "87 to 93 %"),
        ("outside: right axis", share(outside, in_set), "70 %"),
        ("outside: wrong catalogue name", share(outside, _catalogue_name), "at most 10 %"),
        ("seconds of a diagnosis, median and slowest", _seconds(lines), ""),
        (
            "confounded, once speeds are measured: right one",
            share(later, lambda x: x["with_speeds"][1] == x["true"]),
            "named",
        ),
        (
            "ambiguous, once what is told is measured: right one",
            share(told, lambda x: x["as_told"][1] == x["true"]),
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
                    share(mine, in_set),
                    share(mine, first_alone),
                    share(mine, lambda x: one_named(x) and not first_alone(x)),
                    share(mine, _right("bic")),
                    share(mine, _right("regression")),
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


def _mean(lines: Sequence[Line], value: Callable[[Line], float]) -> str:
    if not lines:
        return "-"
    return f"{100.0 * sum(value(x) for x in lines) / len(lines):.0f} %"


def _ratio(lines: Sequence[Line]) -> str:
    ratios = [x["child"][0] / x["oracle"][0] for x in lines if "oracle" in x]
    return f"{median(ratios):.3f} ({len(ratios)} worlds)" if ratios else "-"


def _seconds(lines: Sequence[Line]) -> str:
    if not lines:
        return "-"
    times = [x["seconds"] for x in lines]
    return f"{median(times):.0f}, {max(times):.0f}"


def _crps(lines: Sequence[Line]) -> str:
    kept = [x for x in lines if "oracle" in x]
    if not kept:
        return "-"
    return ", ".join(f"{median(x[k][0] for x in kept):.1f}" for k in ("base", "child", "oracle"))
