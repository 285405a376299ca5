"""All records that belong together, and those of them that a name says."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any
from unicodedata import normalize

from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile
from avahazard.records.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Records:
    """Paths, their profiles, events and speeds, in the order in which they were read.

    Runs of flow models are without their peak pressures.

    `kept` is for what is made of them once (`of_path`).
    """

    paths: tuple[Path, ...] = ()
    profiles: tuple[Profile, ...] = ()
    events: tuple[Event, ...] = ()
    speeds: tuple[Speed, ...] = ()
    simulations: tuple[Simulation, ...] = ()
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False, compare=False)


def find_path(records: Records, path_id: str) -> Path:
    """Return the path of this name.

    Raises `AvahazardError` where there is none; the hint lists those that there are.
    """
    same = (path_id, normalize("NFC", path_id))
    for path in records.paths:
        if path.path_id in same:
            return path
    raise unknown_path(path_id, [path.path_id for path in records.paths])


def unknown_path(path_id: str, names: Sequence[str]) -> AvahazardError:
    """That there is no path of this name among those that there are."""
    if not names:
        hint = "There are no paths yet: import some with `avahazard import`."
    else:
        more = f" and {len(names) - 12} more" if len(names) > 12 else ""
        hint = f"{did_you_mean(path_id, names)}The paths are: {', '.join(names[:12])}{more}."
    return AvahazardError(f"There is no path '{path_id}'.", hint)


def find_profile(records: Records, path: Path) -> Profile:
    """Return the profile of a path. Raises `AvahazardError` where none is stored."""
    for profile in records.profiles:
        if profile.path_id == path.path_id:
            return profile
    raise no_profile(path.path_id)


def no_profile(path_id: str) -> AvahazardError:
    """That a path has no profile."""
    return AvahazardError(
        f"No profile is stored for path {path_id}.",
        "Import a profiles.csv with the points of this path.",
    )


def of_path(records: Records, path_id: str) -> Records:
    """A path with its profile and its events, without speeds; nothing of an unknown path."""
    if "by_path" not in records.kept:
        paths: dict[str, tuple[Path, ...]] = {}
        profiles: dict[str, tuple[Profile, ...]] = {}
        events: dict[str | None, list[Event]] = {}
        for path in records.paths:
            paths[path.path_id] = (path,)
        for profile in records.profiles:
            profiles[profile.path_id] = (profile,)
        for event in records.events:
            events.setdefault(event.path_id, []).append(event)
        records.kept["by_path"] = (paths, profiles, events)
    paths, profiles, events = records.kept["by_path"]
    return Records(
        paths.get(path_id, ()), profiles.get(path_id, ()), tuple(events.get(path_id, ()))
    )


def only_paths(records: Records, paths: Sequence[str]) -> Records:
    """The records of these paths; all where none are named.

    Raises `AvahazardError` for an unknown path, and where the paths have no events.
    """
    if not paths:
        return records
    wanted = {find_path(records, path_id).path_id for path_id in paths}
    events = tuple(e for e in records.events if e.path_id in wanted)
    if not events:
        raise AvahazardError(
            f"There are no events on {', '.join(paths)}.", "Import some: avahazard import FOLDER."
        )
    names = {e.event_id for e in events}
    return Records(
        tuple(p for p in records.paths if p.path_id in wanted),
        tuple(p for p in records.profiles if p.path_id in wanted),
        events,
        tuple(s for s in records.speeds if s.event_id in names),
        tuple(s for s in records.simulations if s.path_id in wanted),
    )


def paths_to_run(
    path_ids: Sequence[str], with_profile: Collection[str], named: Sequence[str]
) -> list[str]:
    """The paths that are named, or all with a profile, in the order of their names.

    Raises `AvahazardError` where a path is unknown or has no profile, or there are none with a
    profile.
    """
    known = set(path_ids)
    for path_id in named:
        if path_id not in known:
            raise unknown_path(path_id, path_ids)
        if path_id not in with_profile:
            raise no_profile(path_id)
    found = sorted(set(named) or known.intersection(with_profile))
    if not found:
        raise AvahazardError(
            "There are no paths with a profile.", "Import paths.csv and profiles.csv first."
        )
    return found
