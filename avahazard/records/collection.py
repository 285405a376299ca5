"""All records that belong together."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile


@dataclass(frozen=True, slots=True)
class Records:
    """Paths, their profiles, events and speeds, in the order in which they were read."""

    paths: tuple[Path, ...] = ()
    profiles: tuple[Profile, ...] = ()
    events: tuple[Event, ...] = ()
    speeds: tuple[Speed, ...] = ()
