"""Friction changes at a date: on one path (a dam, a forest gone), or on all."""

from functools import partial

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.effects.columns import EventColumns, friction_by_paths
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

CHANGE, ALL = "change:", "all"
CHANGE_SD = 0.2
MOST_DATES = 40
"""Dates that are tried, evenly among the events."""


def change(path: str) -> Definition:
    """The effect of a change on a path, or on `all`."""
    where = "all paths" if path == ALL else f"path {path}"
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
        beyond=1,
    )


def _time(columns: EventColumns) -> Floats:
    """Years `[n_events]`, of a day where it is known."""
    return np.where(np.isfinite(columns.day), columns.day / 365.2425 + 1.0, columns.year)


def _there(path: str, columns: EventColumns) -> Bools:
    return np.ones(len(columns), np.bool_) if path == ALL else columns.on_path(path)


def _alternatives(path: str, columns: EventColumns, _sites: Sites) -> list[Facts]:
    """The dates that are tried: between events, with enough of them on either side."""
    time = np.sort(known(_time(columns)[_there(path, columns)]))
    inner = slice(MIN_LEVEL - 1, len(time) - MIN_LEVEL)
    between = (0.5 * (time[1:] + time[:-1]))[inner][np.diff(time)[inner] > 0.0]
    if len(between) > MOST_DATES:
        between = between[np.linspace(0, len(between) - 1, MOST_DATES).round().astype(int)]
    return [{"from_year": round(float(t), 3)} for t in between]


def _lacking_change(path: str, columns: EventColumns, sites: Sites) -> str | None:
    if _alternatives(path, columns, sites):
        return None
    return f"fewer than {2 * MIN_LEVEL} dated events"


def _facts_change(path: str, columns: EventColumns, sites: Sites) -> Facts:
    """The date that parts H/L best, volume and path taken off (least squares)."""
    tried, time = _alternatives(path, columns, sites), _time(columns)
    use, ratio, rest = friction_by_paths(columns)
    dated = np.isfinite(time[use])
    ratio = ratio[dated]

    def left(facts: Facts) -> float:
        after = (_there(path, columns) & (time >= facts["from_year"]))[use]
        design = np.column_stack([rest, after])[dated]
        return float(np.sum((ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]) ** 2))

    return min(tried, key=left)


def _seen_in(path: str, columns: EventColumns, sites: Sites) -> Note | None:
    if _lacking_change(path, columns, sites):
        return None
    date, time = _facts_change(path, columns, sites)["from_year"], _time(columns)
    before, after = (
        int(np.sum(_there(path, columns) & side)) for side in (time < date, time >= date)
    )
    return Note("change_from", year=date, before=before, after=after)


def _build_change(path: str, facts: Facts) -> FrictionEffect:
    def design(columns: EventColumns) -> Floats:
        # What has no date is to come.
        after = ~(_time(columns) < facts["from_year"])
        return np.asarray(after & _there(path, columns), np.float64)[:, None]

    unit = f"log friction from {facts['from_year']:.1f} on"
    parameter = Parameter("change", unit, 0.0, 0.0, CHANGE_SD)
    paths = () if path == ALL else (path,)
    return FrictionEffect(CHANGE + path, (parameter,), design=design, paths=paths)
