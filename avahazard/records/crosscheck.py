"""Checks between records: what they refer to, and their places on the profiles."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from avahazard.records.collection import Records
from avahazard.records.contradictions import place_fault, volume_fault
from avahazard.records.event import Event
from avahazard.records.forms.meanings import ELEVATION
from avahazard.records.intake import Intake, speed_key
from avahazard.records.path import Path, Profile
from avahazard.records.terrain import Fault, release_fault, speed_fault, stop_fault


def check_references(
    intake: Intake, path_ids: AbstractSet[str], event_ids: AbstractSet[str]
) -> None:
    """Refuse events of a path, and speeds of an event, that neither files nor database have."""
    for event in intake.records.events:
        if event.path_id is not None and event.path_id not in path_ids:
            accepted = "a path_id of these files or of the database"
            intake.refuse(("event", event.event_id), "path_id", event.path_id, accepted)
    for speed in intake.records.speeds:
        if speed.event_id not in event_ids:
            accepted = "an event_id of these files or of the database"
            intake.refuse(speed_key(speed), "event_id", speed.event_id, accepted)


def check_places(intake: Intake, known: Records) -> None:
    """Refuse stops, releases and speeds that cannot be found on the profile of their path.

    Refuse events too whose values contradict each other.

    Stored records are checked again where their path has another profile or release now.
    """
    new = intake.records
    profiles = {p.path_id: p for p in (*known.profiles, *new.profiles) if _is_possible(p)}
    paths = {p.path_id: p for p in (*known.paths, *new.paths)}
    changed = {p.path_id for p in new.profiles}
    released = {p.path_id: p.release_elevation_m for p in known.paths}
    # A path that is new has no stored events.
    moved = {p.path_id for p in new.paths if p.release_elevation_m != released.get(p.path_id)}
    read_paths = {p.path_id for p in new.paths}
    read_events = {e.event_id for e in new.events}
    stored_events = [e for e in known.events if e.event_id not in read_events]
    path_of = {e.event_id: e.path_id for e in (*stored_events, *new.events)}

    _check_volumes(intake)
    for path in (*new.paths, *(p for p in known.paths if p.path_id not in read_paths)):
        profile = profiles.get(path.path_id)
        if profile is None or path.path_id not in changed | read_paths:
            continue
        if fault := release_fault(path, profile):
            intake.refuse(("path", path.path_id), *fault)
    for event in (*new.events, *(e for e in stored_events if e.path_id in changed | moved)):
        profile = profiles.get(event.path_id or "")
        if profile is None:
            continue
        for fault in _event_faults(event, paths.get(profile.path_id), profile):
            intake.refuse(("event", event.event_id), *fault)
    read_speeds = {speed_key(s) for s in new.speeds}
    for speed in (*new.speeds, *(s for s in known.speeds if speed_key(s) not in read_speeds)):
        profile = profiles.get(path_of.get(speed.event_id) or "")
        touched = speed_key(speed) in read_speeds or speed.event_id in read_events
        if profile is None or not (touched or profile.path_id in changed):
            continue
        if fault := speed_fault(speed, profile):
            intake.refuse(speed_key(speed), *fault)


def _is_possible(profile: Profile) -> bool:
    """Whether the points lie on the Earth: else they are refused already, and nothing fits them."""
    low, high = ELEVATION.possible
    return bool(low <= profile.y_m.min() and profile.y_m.max() <= high)


def check_one_scale(intake: Intake, known: Records) -> None:
    """Refuse H/L alone beside runouts in metres: no score could be taken over both."""
    read = {e.event_id for e in intake.records.events}
    stored = [e for e in known.events if e.event_id not in read]
    ratios = [e for e in intake.records.events if e.in_ratio]
    others = [e for e in intake.records.events if not e.in_ratio]
    remedy = "or a database of its own: H/L and metres have no score in common"
    if ratios and (others or any(not e.in_ratio for e in stored)):
        first = ratios[0]
        accepted = f"H or L in metres with it, as the other events have, {remedy}"
        intake.refuse(("event", first.event_id), "h_over_l", first.h_over_l or "", accepted)
    elif others and any(e.in_ratio for e in stored):
        accepted = f"h_over_l alone, as the stored events have, {remedy}"
        intake.refuse(("event", others[0].event_id), "event_id", others[0].event_id, accepted)


def _check_volumes(intake: Intake) -> None:
    for event in intake.records.events:
        if fault := volume_fault(event):
            intake.refuse(("event", event.event_id), *fault)


def _event_faults(event: Event, path: Path | None, profile: Profile) -> list[Fault]:
    """What is wrong with the places of an event: each by itself, else with one another."""
    found = [stop_fault(event, profile), release_fault(event, profile)]
    return [fault for fault in found if fault] or [
        fault for fault in [place_fault(event, path, profile)] if fault
    ]
