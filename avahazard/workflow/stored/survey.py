"""One look over all records, of which little is held: enough to work on them path by path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.hazard.frequency import KnownVolumes
from avahazard.hazard.future_events import MAX_CLASSES
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.fingerprint import Fingerprint
from avahazard.records.lookup import of_path, paths_to_run
from avahazard.store.records import PATHS_AT_ONCE, load_by_pieces, load_events, load_paths
from avahazard.store.session import Session


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What is held of the records of a database: their fingerprint, and of each path little.

    `digests` has all paths, in the order in which they were imported, with what tells whether
    their records have changed; `with_profile` those that have one. `others` stand for the events
    of a path without any, where a model takes columns of the event.
    """

    fingerprint: str
    digests: Mapping[str, bytes]
    with_profile: frozenset[str]
    volumes: KnownVolumes
    others: tuple[Event, ...] = ()

    def paths_to_run(self, named: Sequence[str]) -> list[str]:
        """The paths that are named, or all with a profile. Raises as `lookup.paths_to_run`."""
        return paths_to_run(list(self.digests), self.with_profile, named)


def survey(session: Session) -> Survey:
    """Look over all records of a database."""
    whole, volumes = Fingerprint(), KnownVolumes()
    digests: dict[str, bytes] = {}
    with_profile: set[str] = set()
    for piece in load_by_pieces(session):
        for path in piece.paths:
            mine = of_path(piece, path.path_id)
            digests[path.path_id] = whole.add(mine)
            volumes.add(path, mine.events)
        with_profile.update(profile.path_id for profile in piece.profiles)
        pathless = tuple(event for event in piece.events if event.path_id is None)
        whole.add(Records(events=pathless, speeds=piece.speeds))
    return Survey(whole.hexdigest(), digests, frozenset(with_profile), volumes)


def fingerprint_of(session: Session, path_ids: Sequence[str]) -> str:
    """The fingerprint of the records of some paths (`only_paths`)."""
    whole, each = Fingerprint(), list(dict.fromkeys(path_ids))
    for start in range(0, len(each), PATHS_AT_ONCE):
        whole.add(load_paths(session, each[start : start + PATHS_AT_ONCE]))
    return whole.hexdigest()


def any_events(session: Session) -> tuple[Event, ...]:
    """Those of all paths that stand for the events of a path without any (`future_events`)."""
    n = sum(event.path_id is not None for event in load_events(session))
    kept = set(np.linspace(0, n - 1, min(n, MAX_CLASSES)).round().astype(int).tolist())
    there = (event for event in load_events(session) if event.path_id is not None)
    return tuple(event for k, event in enumerate(there) if k in kept)
