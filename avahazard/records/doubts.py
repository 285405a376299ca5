"""Records that are probably wrong, though possible: each gets a note on import.

An avalanche may be recorded twice: lists from several offices have it under two ids. What
varies between avalanches is then zero between such two: storms seem to share their snow, and
intervals are too narrow. Volumes that dwarf all others are slips of units more often than
avalanches. Stops whose error is as large as their path is high tell nothing of friction.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import fields
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.records.event import Event

A_DAY = len("1999-01-31")
COLUMNS = attrgetter(*(f.name for f in fields(Event) if f.name not in ("event_id", "covariates")))
"""All that the forms say of an event but its id."""
SHOWN = 3


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


def repeated_notes(groups: Iterable[Sequence[str]]) -> list[Note]:
    """A note on each of the groups of `repeated`."""
    return [Note("recorded_twice", " = ".join(ids)) for ids in groups]


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


FACTOR = 100.0
"""How many times the next smaller volume one must be to be suspect."""
MOST = 0.05
"""Where more than this share of the records lie beyond a gap, they are another kind of flow."""
FEWEST = 5


def dwarfing(log_volume: NDArray[np.float64]) -> NDArray[np.int64]:
    """Indices of the few volumes `[n]` (log m3, nan if unknown) beyond a gap, largest first."""
    known = np.flatnonzero(np.isfinite(log_volume))
    if len(known) < FEWEST:
        return np.zeros(0, dtype=np.int64)
    order = known[np.argsort(-log_volume[known], kind="stable")]
    most = max(1, int(MOST * len(order)))
    gaps = -np.diff(log_volume[order[: most + 1]])
    wide = np.flatnonzero(gaps > np.log(FACTOR))
    return order[: wide[-1] + 1] if len(wide) else order[:0]


def vague_stops(new: Records, stored: Records) -> list[str]:
    """A note on the new events whose error reaches the drop of their path's profile, if any."""
    profiles = {p.path_id: p for p in (*stored.profiles, *new.profiles)}
    drops = {key: float(np.max(p.y_m) - np.min(p.y_m)) for key, p in profiles.items()}
    found = [
        f"{e.event_id}: {e.runout_sigma_m:g} m, {e.path_id} drops {drops[e.path_id]:.0f} m"
        for e in new.events
        if e.path_id in drops and not e.left_profile and e.runout_sigma_m >= drops[e.path_id]
    ]
    if not found:
        return []
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return [
        f"runout_sigma_m is not below the drop of the path ({'; '.join(found[:SHOWN])}{more}): "
        "such a stop says nothing about friction. Is its unit m?"
    ]
