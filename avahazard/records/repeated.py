"""Avalanches that may be written down twice: each would count twice, and share its scatter.

Lists from several offices have the same avalanche under two ids. What varies between avalanches
is then nought between such two: storms seem to share their snow, and intervals are too narrow.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import fields
from operator import attrgetter

from avahazard.message import message
from avahazard.records.event import Event

A_DAY = len("1999-01-31")
COLUMNS = attrgetter(*(f.name for f in fields(Event) if f.name not in ("event_id", "covariates")))
"""All that the forms say of an event but its id."""
SHOWN = 3
ALIKE = message(
    "events {events} are alike in path, day and stop, or in all columns: is that one avalanche "
    "written down twice? It would count twice: keep one row of it."
)
MORE_ALIKE = message("{n} more avalanches may be written down twice.")
ONE_ALIKE = message("1 more avalanche may be written down twice.")


def repeated(events: Iterable[Event]) -> list[tuple[str, ...]]:
    """The ids of events that are alike in path, day and stop, or in all but their id.

    Two avalanches may stop at one rounded place in the same year: where the day is not known, they
    must have the same volume and all else too. Those without a recorded stop are never alike.
    """
    groups: dict[Hashable, list[str]] = {}
    for event in events:
        if (key := _told_by(event)) is not None:
            groups.setdefault(key, []).append(event.event_id)
    return [tuple(ids) for ids in groups.values() if len(ids) > 1]


def repeated_notes(groups: Sequence[Sequence[str]]) -> list[str]:
    """Sentences on the groups of `repeated`: the first few, and how many others there are."""
    found = [ALIKE.format(events=" = ".join(ids)) for ids in groups]
    rest = len(found) - SHOWN
    if rest <= 0:
        return found
    return [*found[:SHOWN], ONE_ALIKE if rest == 1 else MORE_ALIKE.format(n=rest)]


def _told_by(event: Event) -> Hashable | None:
    """What tells an event from others, None where too little is known."""
    stop = (
        event.runout_elevation_m,
        event.runout_x_m,
        event.fall_height_m,
        event.runout_length_m,
        event.h_over_l,
    )
    if all(value is None for value in stop):
        return None
    if event.date is not None and len(event.date) == A_DAY and event.path_id is not None:
        return event.path_id, event.date, stop
    if event.volume_m3 is None:
        return None
    # A record read from a file and one from the database may differ in the order of columns.
    own = tuple(sorted((name, str(value)) for name, value in event.covariates.items()))
    return *COLUMNS(event), own
