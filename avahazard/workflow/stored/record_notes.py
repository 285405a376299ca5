"""What whoever reads a model must know of the records that it was calibrated on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from avahazard.effects.site import Site
from avahazard.message import message
from avahazard.records.collection import Records
from avahazard.records.crosscheck import place_fault, unseen_elevation, volume_fault
from avahazard.records.doubts import repeated, repeated_notes
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile

Paths = Mapping[str, Path]
Profiles = Mapping[str, Profile]

MISFIT_M = 10.0
"""Deviation of the regularised path from its points from which a reader is told."""
MISFIT_SIGMAS = 4.0
"""… where it is also that many times their error: the farthest of hundreds lies some 3 away."""
SHOWN = 3
MISSES = message(
    "the path {path} that the block runs on misses the points of its profile by {away} at x = {x}. "
    "Look at it: avahazard path {path} --plot FILE."
)
CONTRADICTS = message(
    "the record of event {event} contradicts itself: {column} is {value}; accepted would be "
    "{accepted}."
)
UNSEEN_ONE = message(
    "a record of path {path} stops over its observed_below_m ({limit} m), where none is said to be "
    "seen: event {event} at {elevation} m. Correct the limit, or this record."
)
UNSEEN = message(
    "{n} records of path {path} stop over its observed_below_m ({limit} m), where none is said to "
    "be seen; that of event {event} at {elevation} m. Correct the limit, or these records."
)
ONE_MISSES = message("1 more path misses the points of its profile.")
MORE_MISS = message("{n} more paths miss the points of their profiles.")
ONE_CONTRADICTS = message("1 more record contradicts itself.")
MORE_CONTRADICT = message("{n} more records contradict themselves.")
ONE_UNSEEN = message("1 more path has records over its observed_below_m.")
MORE_UNSEEN = message("{n} more paths have records over their observed_below_m.")


def record_notes(records: Records, sites: Sequence[Site]) -> tuple[str, ...]:
    """Paths that miss their terrain, events that cannot be true, or are there twice, unseen stops.

    An import refuses the second; a database of an earlier version may hold them.
    """
    profiles = {profile.path_id: profile for profile in records.profiles}
    paths = {path.path_id: path for path in records.paths}
    return (
        *_misfits(profiles, sites),
        *_contradictions(records.events, paths, profiles),
        *_unseen(records.events, paths, profiles),
        *repeated_notes(repeated(records.events)),
    )


def _misfits(profiles: Profiles, sites: Sequence[Site]) -> list[str]:
    found = []
    for site in {site.path.path_id: site for site in sites}.values():
        profile, smooth = profiles.get(site.path.path_id), site.smooth
        if profile is None:  # a straight line has no points to miss
            continue
        away = np.abs(smooth.height(profile.x_m) - profile.y_m)
        farthest = int(np.argmax(away))
        if away[farthest] > max(MISFIT_M, MISFIT_SIGMAS * smooth.sigma_m):
            off, x = (f"{value:.0f} m" for value in (away[farthest], profile.x_m[farthest]))
            found.append(MISSES.format(path=site.path.path_id, away=off, x=x))
    return _first(found, ONE_MISSES, MORE_MISS)


def _contradictions(events: Sequence[Event], paths: Paths, profiles: Profiles) -> list[str]:
    found = []
    for event in events:
        fault = volume_fault(event)
        profile = profiles.get(event.path_id or "")
        if fault is None and profile is not None:
            fault = place_fault(event, paths.get(profile.path_id), profile)
        if fault is not None:
            column, value, accepted = fault
            found.append(
                CONTRADICTS.format(
                    event=event.event_id, column=column, value=f"{value:g}", accepted=accepted
                )
            )
    return _first(found, ONE_CONTRADICTS, MORE_CONTRADICT)


def _unseen(events: Sequence[Event], paths: Paths, profiles: Profiles) -> list[str]:
    over: dict[str, list[tuple[float, str]]] = {}
    for event in events:
        path = paths.get(event.path_id or "")
        if path is None:
            continue
        elevation = unseen_elevation(event, path, profiles.get(path.path_id))
        if elevation is not None:
            over.setdefault(path.path_id, []).append((elevation, event.event_id))
    found = []
    for path_id, stops in over.items():
        elevation, event_id = max(stops)
        found.append(
            (UNSEEN if len(stops) > 1 else UNSEEN_ONE).format(
                n=len(stops),
                path=path_id,
                limit=f"{paths[path_id].observed_below_m:g}",
                event=event_id,
                elevation=f"{elevation:.0f}",
            )
        )
    return _first(found, ONE_UNSEEN, MORE_UNSEEN)


def _first(found: Sequence[str], one: str, more: str) -> list[str]:
    """The first of the notes, and how many others there are."""
    rest = len(found) - SHOWN
    if rest <= 0:
        return [*found]
    return [*found[:SHOWN], one if rest == 1 else more.format(n=rest)]
