"""Friction changes at a date: on one path (a dam, a forest gone), on several, or on all."""

from collections.abc import Sequence
from functools import partial

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

CHANGE, ALL, SEVERAL = "change:", "all", "several"
CHANGE_SD = 0.2
MOST_DATES = 40
"""Dates that are tried, evenly among the events."""


def change(path: str) -> Definition:
    """The effect of a change on a path, on `several`, each by its own amount, or on `all`."""
    where = {ALL: "all paths", SEVERAL: "some of the paths"}.get(path, f"path {path}")
    return Definition(
        key=CHANGE + path,
        meaning=f"From some date on friction on {where} is another: something was built or taken "
        "away, or records were made otherwise. The date is the one that the data tell best.",
        needs="date",
        build=partial(_build_change, path),
        lacking=partial(_lacking_change, path),
        facts=partial(_facts_change, path),
        alternatives=partial(_alternatives, path),
        event_columns=True,
        seen_in=partial(_seen_in, path),
        beyond=2 if path == SEVERAL else 1,
    )


def _time(columns: EventColumns) -> Floats:
    """Years `[n_events]`, of a day where it is known."""
    return np.where(np.isfinite(columns.day), columns.day / 365.2425 + 1.0, columns.year)


def _there(path: str, columns: EventColumns, facts: Facts) -> Bools:
    """Events `[n_events, n]` at which each of the parameters acts, before the date or after."""
    if path == ALL:
        return np.ones((len(columns), 1), np.bool_)
    paths = facts["paths"] if path == SEVERAL else [path]
    return np.column_stack([columns.on_path(one) for one in paths])


def _everywhere(path: str, columns: EventColumns) -> Facts:
    """Of a change on several paths all those with enough events."""
    if path != SEVERAL:
        return {}
    enough = [one for one in columns.paths if np.sum(columns.on_path(one)) >= 2 * MIN_LEVEL]
    return {"paths": sorted(enough)}


def _gaps(path: str, columns: EventColumns) -> Floats:
    """Times `[n, 2]` between which the date may be: of one event and of the next.

    With enough events on either side.
    """
    facts = _everywhere(path, columns)
    if path == SEVERAL and len(facts["paths"]) < 2:
        return np.empty((0, 2))
    time = np.sort(known(_time(columns)[_there(path, columns, facts).any(axis=1)]))
    gaps = np.column_stack([time[:-1], time[1:]])[MIN_LEVEL - 1 : len(time) - MIN_LEVEL]
    gaps = gaps[gaps[:, 1] > gaps[:, 0]]
    if len(gaps) > MOST_DATES:
        gaps = gaps[np.linspace(0, len(gaps) - 1, MOST_DATES).round().astype(int)]
    return np.asarray(gaps)


def _alternatives(path: str, columns: EventColumns, _sites: Sites) -> list[Facts]:
    """The dates that are tried, in the middle between events."""
    dates, facts = _gaps(path, columns).mean(axis=1), _everywhere(path, columns)
    return [{"from_year": round(float(t), 3), **facts} for t in dates]


def _lacking_change(path: str, columns: EventColumns, sites: Sites) -> str | None:
    if _alternatives(path, columns, sites):
        return None
    on_two = " on each of two paths" if path == SEVERAL else ""
    return f"fewer than {2 * MIN_LEVEL} dated events{on_two}"


def _log_odds(path: str, columns: EventColumns, tried: Sequence[Facts]) -> Floats:
    """Of dates `[n]`, by how they part H/L, volume and path taken off (least squares)."""
    time = _time(columns)
    use, ratio, rest = friction_by_paths(columns)
    dated = np.isfinite(time[use])
    ratio, odds = ratio[dated], np.empty(len(tried))
    for k, facts in enumerate(tried):
        after = (_there(path, columns, facts) & (time >= facts["from_year"])[:, None])[use]
        design = np.column_stack([rest, after])[dated]
        left = ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]
        odds[k] = -0.5 * len(ratio) * np.log(max(float(left @ left), 1e-12))
    return odds


def _facts_change(path: str, columns: EventColumns, sites: Sites) -> Facts:
    """The date that the data tell best."""
    tried = _tried_there(path, columns, sites)
    return tried[int(np.argmax(_log_odds(path, columns, tried)))]


def _tried_there(path: str, columns: EventColumns, sites: Sites) -> list[Facts]:
    """The dates that are tried, of a change on several paths on those where there is one."""
    tried = _alternatives(path, columns, sites)
    if path != SEVERAL or not tried:
        return tried
    likeliest = tried[int(np.argmax(_log_odds(path, columns, tried)))]

    def nats(paths: Sequence[str]) -> float:
        explained = _log_odds(path, columns, [{**likeliest, "paths": paths}])[0]
        return float(explained - 0.5 * np.log(len(columns)) * len(paths))

    on = where_it_acts(likeliest["paths"], nats)
    return [{**facts, "paths": on} for facts in tried]


def _seen_in(path: str, columns: EventColumns, sites: Sites) -> Note | None:
    tried = _tried_there(path, columns, sites)
    if not tried:
        return None
    odds, gaps, time = _log_odds(path, columns, tried), _gaps(path, columns), _time(columns)
    best = tried[int(np.argmax(odds))]
    date, there = best["from_year"], _there(path, columns, best).any(axis=1)
    before, after = (int(np.sum(there & side)) for side in (time < date, time >= date))
    # Between two events any day is as likely as another.
    share = np.exp(odds - odds.max()) * np.diff(gaps)[:, 0]
    ends = np.concatenate([[0.0], np.cumsum(share / share.sum())])
    low, high = (_at_share(q, ends, gaps) for q in (0.05, 0.95))
    on = {"paths": best["paths"]} if path == SEVERAL else {}
    key = "change_on" if on else "change_from"
    return Note(key, year=date, before=before, after=after, low=low, high=high, **on)


def _at_share(q: float, ends: Floats, gaps: Floats) -> float:
    """The time before which the date is with probability q; `ends` `[n + 1]` those of the gaps."""
    k = int(np.clip(np.searchsorted(ends, q) - 1, 0, len(gaps) - 1))
    part = (q - ends[k]) / max(ends[k + 1] - ends[k], 1e-12)
    return float(gaps[k, 0] + part * (gaps[k, 1] - gaps[k, 0]))


def _build_change(path: str, facts: Facts) -> FrictionEffect:
    def design(columns: EventColumns) -> Floats:
        # What has no date is to come.
        after = ~(_time(columns) < facts["from_year"])
        return np.asarray(after[:, None] & _there(path, columns, facts), np.float64)

    unit = f"log friction from {facts['from_year']:.1f} on"
    paths = () if path == ALL else tuple(facts.get("paths", [path]))
    names = paths if path == SEVERAL else ("change",)
    parameters = tuple(Parameter(name, unit, 0.0, 0.0, CHANGE_SD) for name in names)
    return FrictionEffect(CHANGE + path, parameters, design=design, paths=paths)
