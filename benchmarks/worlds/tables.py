"""What the lines of the loop add up to: the targets, then every arm, then what went wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import sqrt
from statistics import median

from benchmarks.study import Line, bullets, table
from benchmarks.worlds.beyond import SPEEDS

GAINS, OF_CATALOGUE = 15.0, 10.0
"""Nats that one who knows the form must gain for a dataset to count."""
LEAST_GAP = 0.05
Z = 1.96


def same(key: str) -> str:
    """A key in one spelling: the columns of a pair in order, the volume with its unit or not."""
    kind, _, rest = key.partition(":")
    if kind == "path":  # of few paths the one that differs most is named
        return "path-effect"
    if kind == "interaction":
        rest = "*".join(sorted(name.removesuffix("_m3") for name in rest.split("*")))
    return f"{kind}:{rest}" if rest else kind


def names(line: Line, k: int) -> set[str]:
    """What round k named."""
    return {same(key) for key in line["rounds"][k][1]}


def right(line: Line) -> set[str]:
    """Keys that are right."""
    return {same(key) for key in line["right"]}


def false(line: Line, k: int) -> bool:
    """Whether round k named something, and nothing that is there or harmless."""
    named = names(line, k)
    return bool(named) and not named & {*right(line), *map(same, line["neutral"])}


def false_at_all(line: Line) -> bool:
    """Whether any round named falsely."""
    return any(false(line, k) for k in range(len(line["rounds"])))


def false_later(line: Line) -> bool:
    """Whether a round after the first named falsely."""
    return any(false(line, k) for k in range(1, len(line["rounds"])))


def in_set(line: Line) -> bool:
    """Whether any round had a right key in its set."""
    return any(names(line, k) & right(line) for k in range(len(line["rounds"])))


def alone(line: Line) -> bool:
    """Whether any round named one key, and it is right."""
    sets = [names(line, k) for k in range(len(line["rounds"]))]
    return any(len(named) == 1 and named <= right(line) for named in sets)


def wrong_alone(line: Line) -> bool:
    """Whether any round named one effect of the catalogue alone, which is not there."""
    return any(
        len(names(line, k)) == 1 and false(line, k) and ":" not in line["rounds"][k][1][0]
        for k in range(len(line["rounds"]))
    )


def closed(lines: Iterable[Line]) -> list[float]:
    """Of the gap in held-out CRPS between base model and who knows the form, the share that the
    loop closes; datasets with a gap over `LEAST_GAP` alone."""
    shares = []
    for line in lines:
        base, last = line["crps"][0], line["crps"][-1]
        if line.get("knows") is not None and base - line["knows"] > LEAST_GAP * base:
            shares.append((base - last) / (base - line["knows"]))
    return shares


def wilson(k: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share of which k of n were seen (Wilson 1927)."""
    middle, spread = k + Z * Z / 2.0, Z * sqrt(k * (n - k) / n + Z * Z / 4.0)
    return (middle - spread) / (n + Z * Z), (middle + spread) / (n + Z * Z)


def share(lines: Sequence[Line], is_so: Callable[[Line], bool], interval: bool = True) -> str:
    """The share of lines that are so, with counts and its 95 % interval."""
    if not lines:
        return "–"
    k, n = sum(map(is_so, lines)), len(lines)
    text = f"{k}/{n} = {100.0 * k / n:.0f} %"
    low, high = (abs(round(100.0 * v)) for v in wilson(k, n))
    return f"{text} ({low} to {high})" if interval else text


def arm(line: Line) -> str:
    """The arm of a line."""
    return str(line["name"].rpartition(" #")[0])


def parts(lines: Sequence[Line]) -> dict[str, str]:
    """The parts of the page, by name."""
    return {
        "targets": targets(lines),
        "effects": effects([x for x in lines if x["right"]]),
        "nulls": nulls([x for x in lines if not x["right"]]),
        "failures": bullets(failures(lines), "None."),
    }


def targets(lines: Sequence[Line]) -> str:
    """A row for each of what must hold."""
    listed = [x for x in lines if arm(x).startswith("catalogue")]
    seen = [x for x in listed if x["gain"] > OF_CATALOGUE]
    beyond = [x for x in lines if x["right"] and x not in listed]
    clear = [x for x in beyond if x["gain"] > GAINS]
    nothing = [x for x in lines if not x["right"]]
    inside = [x["inside"] for x in beyond if x.get("inside") is not None]
    tracks = [x for x in lines if arm(x).endswith(SPEEDS)]
    stops = [x for x in lines if x not in tracks and x not in listed]
    kinds = f"not in the catalogue, gain over {GAINS:g} nats"
    rows = [
        (f"{kinds}: right kind in the set", share(clear, in_set), "≥ 80 %"),
        ("… right kind alone", share(clear, alone), "≥ 60 %"),
        ("… wrong effect of the catalogue alone", share(clear, wrong_alone), "≤ 5 %"),
        ("… false name in a round after the first", share(clear, false_later), "≤ 5 %"),
        ("gap in held-out CRPS closed, median", _median(closed(beyond)), "≥ 70 %"),
        ("nulls: false name in the first round", share(nothing, lambda x: false(x, 0)), "≤ 5 %"),
        ("… in any round", share(nothing, false_at_all), "≤ 5 %"),
        (f"catalogue, gain over {OF_CATALOGUE:g} nats: in the set", share(seen, in_set), "≥ 94 %"),
        ("90 % band of a found force: share of the true one inside", _mean(inside), "87 to 93 %"),
        ("CPU time of a diagnosis (s), no speeds: median, maximum", _seconds(stops), "≤ 20"),
        ("… with 45 tracks of speeds", _seconds(tracks), "≤ 30"),
        ("datasets on which a command failed", share(lines, lambda x: "error" in x), "none"),
    ]
    return table(("what", "result", "target"), rows)


def effects(lines: Sequence[Line]) -> str:
    """A row for each arm in which something is missing."""
    head = (
        "arm", "datasets", "gain (nats)", "right kind in the set", "alone", "wrong name alone",
        "false name later", "held-out CRPS (m): base", "after the loop", "oracle", "gap closed",
    )  # fmt: skip
    rows = []
    for of in sorted({arm(x) for x in lines}):
        selected = [x for x in lines if arm(x) == of]
        known = [x for x in selected if x.get("knows") is not None]
        counts = (share(selected, so, False) for so in (in_set, alone, wrong_alone, false_later))
        errors = [[x["crps"][0], x["crps"][-1], x["knows"]] for x in known]
        medians = [f"{median(column):.1f}" for column in zip(*errors, strict=True)] or ["–"] * 3
        gain = f"{median(x['gain'] for x in selected):.0f}"
        rows.append((of, len(selected), gain, *counts, *medians, _median(closed(selected))))
    return table(head, rows)


def nulls(lines: Sequence[Line]) -> str:
    """A row for each arm in which nothing is missing."""
    rows = []
    for of in sorted({arm(x) for x in lines}):
        selected = [x for x in lines if arm(x) == of]
        rows.append(
            (
                of,
                len(selected),
                share(selected, lambda x: false(x, 0)),
                share(selected, false_at_all),
            )
        )
    return table(("arm", "datasets", "false name in the first round", "in any round"), rows)


def failures(lines: Sequence[Line]) -> list[str]:
    """Datasets with a false name, one missed, or a command that failed."""
    told = []
    for x in lines:
        missed = x["right"] and x["gain"] > GAINS and not in_set(x)
        if missed or false_at_all(x) or "error" in x:
            rounds = "; ".join(", ".join(f"`{k}`" for k in r[1]) or r[0] for r in x["rounds"])
            gain = f" (gain {x['gain']:.0f})" if x["right"] else ""
            error = f"; {x['error']}" if "error" in x else ""
            told.append(f"{x['name']}{gain}: {rounds}{error}")
    return told


def _median(shares: Sequence[float]) -> str:
    return f"{median(shares):.0%} ({len(shares)})" if shares else "–"


def _mean(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.0%} ({len(values)} bands)" if values else "–"


def _seconds(lines: Iterable[Line]) -> str:
    seconds = [r[2] for x in lines for r in x["rounds"]]
    return f"{median(seconds):.0f}, {max(seconds):.0f}" if seconds else "–"
