"""Friction changes at a date: on one path (a dam, a forest gone), on several, or on all.

Or on all for a span of years alone.
"""

from collections.abc import Sequence
from functools import partial
from itertools import chain, combinations

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.effects.columns import EventColumns, friction_by_paths, where_it_acts
from avahazard.effects.effect import (
    MIN_LEVEL,
    Definition,
    Facts,
    FrictionEffect,
    Parameter,
    Sites,
    known,
)
from avahazard.notes import Note

CHANGE, ALL, SEVERAL, YEARS = "change:", "all", "several", "years"
CHANGE_SD = 0.2
MOST_DATES, MOST_ENDS, MOST_NEAR = 40, 24, 200
"""Dates that are tried, evenly among the events, those of which two are the ends of a span, and
those tried about the likeliest."""


def change(path: str) -> Definition:
    """The effect of a change on a path, on `several`, each by its own amount, or on `all`.

    Or on all of them for a span of `years` alone.
    """
    where = {ALL: "all paths", SEVERAL: "some of the paths"}.get(path, f"path {path}")
    meaning = (
        f"From some date on friction on {where} is another: something was built or taken away, or "
        "records were made otherwise. The date is the one that the data tell best."
    )
    if path == YEARS:
        meaning = (
            "For some years friction on all paths is another: records were made otherwise, or "
            "something stood that is gone again. The years are those that the data tell best."
        )
    return Definition(
        key=CHANGE + path,
        meaning=meaning,
        needs="date",
        build=partial(_build_change, path),
        lacking=partial(_lacking_change, path),
        facts=partial(_facts_change, path),
        alternatives=partial(_alternatives, path),
        event_columns=True,
        seen_in=partial(_seen_in, path),
        beyond=2 if path in (SEVERAL, YEARS) else 1,
    )


def _time(columns: EventColumns) -> Floats:
    """Years `[n_events]`, of a day where it is known."""
    return np.where(np.isfinite(columns.day), columns.day / 365.2425 + 1.0, columns.year)


def _since(columns: EventColumns, facts: Facts) -> Bools:
    """Events `[n_events]` from the date on, to the end of a span; what has no date is to come."""
    time = np.nan_to_num(_time(columns), nan=np.inf)
    return np.asarray((time >= facts["from_year"]) & ~(time >= facts.get("until_year", np.nan)))


def _there(path: str, columns: EventColumns, facts: Facts) -> Bools:
    """Events `[n_events, n]` at which each of the parameters acts, before the date or after."""
    if path in (ALL, YEARS):
        return np.ones((len(columns), 1), np.bool_)
    paths = facts["paths"] if path == SEVERAL else [path]
    return np.column_stack([columns.on_path(one) for one in paths])


def _everywhere(path: str, columns: EventColumns) -> Facts:
    """Of a change on several paths all those with enough events."""
    if path != SEVERAL:
        return {}
    enough = [one for one in columns.paths if np.sum(columns.on_path(one)) >= 2 * MIN_LEVEL]
    return {"paths": sorted(enough)}


def _gaps(path: str, columns: EventColumns, most: int) -> Floats:
    """Times `[n, 2]` between which the date may be: of one event and of the next.

    With enough events on either side; `most` at most.
    """
    facts = _everywhere(path, columns)
    if path == SEVERAL and len(facts["paths"]) < 2:
        return np.empty((0, 2))
    time = np.sort(known(_time(columns)[_there(path, columns, facts).any(axis=1)]))
    gaps = np.column_stack([time[:-1], time[1:]])[MIN_LEVEL - 1 : len(time) - MIN_LEVEL]
    gaps = gaps[gaps[:, 1] > gaps[:, 0]]
    if len(gaps) > most:
        gaps = gaps[np.linspace(0, len(gaps) - 1, most).round().astype(int)]
    return np.asarray(gaps)


def _alternatives(path: str, columns: EventColumns, _sites: Sites) -> list[Facts]:
    """The dates that are tried, in the middle between events, or the spans between two of them."""
    if path == YEARS:
        ends = combinations(_dates(path, columns, MOST_ENDS), 2)
        return _long_enough(columns, [{"from_year": a, "until_year": b} for a, b in ends])
    facts = _everywhere(path, columns)
    return [{"from_year": t, **facts} for t in _dates(path, columns, MOST_DATES)]


def _dates(path: str, columns: EventColumns, most: int) -> list[float]:
    found: list[float] = _gaps(path, columns, most).mean(axis=1).round(3).tolist()
    return found


def _long_enough(columns: EventColumns, spans: Sequence[Facts]) -> list[Facts]:
    """The spans with enough events."""
    dated = np.isfinite(_time(columns))
    return [span for span in spans if np.sum(_since(columns, span) & dated) >= MIN_LEVEL]


def _lacking_change(path: str, columns: EventColumns, sites: Sites) -> str | None:
    if _alternatives(path, columns, sites):
        return None
    on_two = " on each of two paths" if path == SEVERAL else ""
    return f"fewer than {(3 if path == YEARS else 2) * MIN_LEVEL} dated events{on_two}"


def _log_odds(path: str, columns: EventColumns, tried: Sequence[Facts]) -> Floats:
    """Of dates `[n]`, by how they part H/L, volume and path taken off (least squares)."""
    use, ratio, rest = friction_by_paths(columns)
    dated = np.isfinite(_time(columns)[use])
    ratio, odds = ratio[dated], np.empty(len(tried))
    for k, facts in enumerate(tried):
        after = (_there(path, columns, facts) & _since(columns, facts)[:, None])[use]
        design = np.column_stack([rest, after])[dated]
        left = ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]
        odds[k] = -0.5 * len(ratio) * np.log(max(float(left @ left), 1e-12))
    return odds


def _facts_change(path: str, columns: EventColumns, sites: Sites) -> Facts:
    """The date that the data tell best."""
    tried = _tried_there(path, columns, sites)
    return tried[int(np.argmax(_log_odds(path, columns, tried)))]


def _tried_there(path: str, columns: EventColumns, sites: Sites) -> list[Facts]:
    """Any date about the likeliest of those that are tried, or either end of the likeliest span.

    Each end is sought given the other; a change on several paths is on those where there is one.
    """
    tried = _alternatives(path, columns, sites)
    if not tried:
        return tried
    likeliest = tried[int(np.argmax(_log_odds(path, columns, tried)))]

    def nats(paths: Sequence[str]) -> float:
        explained = _log_odds(path, columns, [{**likeliest, "paths": paths}])[0]
        return float(explained - 0.5 * np.log(len(columns)) * len(paths))

    if path == SEVERAL:
        likeliest = {**likeliest, "paths": where_it_acts(likeliest["paths"], nats)}
    dates, about = _dates(path, columns, MOST_NEAR), dict[str, list[Facts]]()
    for end in ("from_year", "until_year", "from_year") if path == YEARS else ("from_year",):
        about[end] = _long_enough(columns, [likeliest, *({**likeliest, end: t} for t in dates)])
        likeliest = about[end][int(np.argmax(_log_odds(path, columns, about[end])))]
    return [*chain.from_iterable(about.values())]


def _seen_in(path: str, columns: EventColumns, sites: Sites) -> Note | None:
    tried = _tried_there(path, columns, sites)
    if not tried:
        return None
    best = tried[int(np.argmax(_log_odds(path, columns, tried)))]
    of_path = _there(path, columns, best).any(axis=1) & np.isfinite(_time(columns))
    after = int(np.sum(of_path & _since(columns, best)))
    found = {"year": best["from_year"], "before": int(np.sum(of_path)) - after, "after": after}
    found["low"], found["high"] = _ends(path, columns, "from_year", tried, best)
    if path == YEARS:
        first, last = _ends(path, columns, "until_year", tried, best)
        return Note("change_for", until=best["until_year"], first=first, last=last, **found)
    if path == SEVERAL:
        return Note("change_on", paths=best["paths"], **found)
    return Note("change_from", **found)


def _ends(
    path: str, columns: EventColumns, end: str, tried: Sequence[Facts], best: Facts
) -> tuple[float, float]:
    """The interval (90 %) of a date by its name, `end`, given the rest of what is `best`."""
    tried = [facts for facts in tried if {**facts, end: best[end]} == best]
    gaps = _gaps(path, columns, MOST_NEAR)
    odds, at = _log_odds(path, columns, tried), np.searchsorted(gaps[:, 1], [f[end] for f in tried])
    # Between two events any day is as likely as another.
    share = np.zeros(len(gaps))
    share[at] = np.exp(odds - odds.max()) * np.diff(gaps)[at, 0]
    ends = np.concatenate([[0.0], np.cumsum(share / share.sum())])
    return _at_share(0.05, ends, gaps), _at_share(0.95, ends, gaps)


def _at_share(q: float, ends: Floats, gaps: Floats) -> float:
    """The time before which the date is with probability q; `ends` `[n + 1]` those of the gaps."""
    k = int(np.clip(np.searchsorted(ends, q) - 1, 0, len(gaps) - 1))
    part = (q - ends[k]) / max(ends[k + 1] - ends[k], 1e-12)
    return float(gaps[k, 0] + part * (gaps[k, 1] - gaps[k, 0]))


def _build_change(path: str, facts: Facts) -> FrictionEffect:
    def design(columns: EventColumns) -> Floats:
        after = _since(columns, facts)[:, None]
        return np.asarray(after & _there(path, columns, facts), np.float64)

    until = f"to {facts['until_year']:.1f}" if path == YEARS else "on"
    unit = f"log friction from {facts['from_year']:.1f} {until}"
    paths = () if path in (ALL, YEARS) else tuple(facts.get("paths", [path]))
    names = paths if path == SEVERAL else ("change",)
    parameters = tuple(Parameter(name, unit, 0.0, 0.0, CHANGE_SD) for name in names)
    return FrictionEffect(CHANGE + path, parameters, design=design, paths=paths)
