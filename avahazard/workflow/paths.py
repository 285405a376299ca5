"""The paths and what is recorded on each."""

from __future__ import annotations

from collections import defaultdict

from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.results.base import Rows
from avahazard.results.terrain import PathSummary
from avahazard.store.records import load_records
from avahazard.store.session import reading


def list_paths(database: str) -> Rows[PathSummary]:
    """Return one entry a path: its profile's size, its number of events, their volumes.

    Raises:
        AvahazardError: the database cannot be used.
    """
    with reading(database) as session:
        return summarise_paths(load_records(session))


def summarise_paths(records: Records) -> Rows[PathSummary]:
    """Return the entries of `list_paths`; lengths in m, volumes in m3, None where unknown."""
    profiles = {profile.path_id: profile for profile in records.profiles}
    events: defaultdict[str | None, list[Event]] = defaultdict(list)
    for event in records.events:
        events[event.path_id].append(event)
    rows = []
    for path in records.paths:
        profile = profiles.get(path.path_id)
        volumes = [e.volume_m3 for e in events[path.path_id] if e.volume_m3 is not None]
        years = [e.year for e in events[path.path_id] if e.year is not None]
        rows.append(
            PathSummary(
                path_id=path.path_id,
                name=path.name,
                section=path.section,
                n_points=0 if profile is None else len(profile.x_m),
                top_m=None if profile is None else float(profile.y_m[0]),
                drop_m=None if profile is None else float(profile.y_m[0] - profile.y_m.min()),
                length_m=None if profile is None else float(profile.x_m[-1] - profile.x_m[0]),
                n_events=len(events[path.path_id]),
                n_left_profile=sum(e.left_profile for e in events[path.path_id]),
                first_year=min(years, default=None),
                last_year=max(years, default=None),
                volume_min_m3=min(volumes, default=None),
                volume_max_m3=max(volumes, default=None),
            )
        )
    return Rows(rows)
