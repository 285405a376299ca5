"""Records just read against the records stored before, number by number."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import TypeVar

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.errors import told_once
from avahazard.records.event import Event, Speed
from avahazard.records.intake import Intake, Key, speed_key
from avahazard.records.path import Path, Profile

Difference = tuple[str, object, object]  # column, one value, the other value


def differences(one: Path | Event | Speed, other: Path | Event | Speed) -> list[Difference]:
    """Return the columns in which `one` and `other` differ; numbers are compared exactly."""
    found: list[Difference] = []
    for name in (f.name for f in fields(one)):
        left, right = getattr(one, name), getattr(other, name)
        if name == "covariates":
            for column in {**left, **right}:
                if left.get(column) != right.get(column):
                    found.append((column, left.get(column), right.get(column)))
        elif left != right:
            found.append((name, left, right))
    return found


def profile_difference(one: Profile, other: Profile) -> tuple[int, Difference] | None:
    """Return the first point at which two profiles differ and how, None when they are equal."""
    n = min(len(one.x_m), len(other.x_m))
    first: tuple[int, Difference] | None = None
    for name in (f.name for f in fields(Profile)):
        left, right = getattr(one, name), getattr(other, name)
        if name == "path_id" or left is right:
            continue
        place: int | None
        if left is None or right is None:
            place = 0
        elif isinstance(left, str):
            place = None if left == right else 0
        else:
            unequal = np.nonzero(np.asarray(left[:n]) != np.asarray(right[:n]))[0]
            place = int(unequal[0]) if len(unequal) else None
        if place is not None and (first is None or place < first[0]):
            first = (place, (name, _at(left, place), _at(right, place)))
    if first is None and len(one.x_m) != len(other.x_m):
        first = (n - 1, ("path_id", f"{len(one.x_m)} points", f"{len(other.x_m)} points"))
    return first


def _at(values: object, place: int) -> object:
    if isinstance(values, str) or values is None:
        return values
    return values[place]  # type: ignore[index]


T = TypeVar("T", Path, Event, Speed)


@dataclass
class Count:
    """How many records of one kind are new, as stored, or replace a stored one."""

    new: int = 0
    unchanged: int = 0
    updated: int = 0


@dataclass
class Merge:
    """What has to be written, and the counts by kind."""

    write: Records = field(default_factory=Records)
    counts: dict[str, Count] = field(default_factory=dict)


def merge_records(intake: Intake, stored: Records, *, update: bool = False) -> Merge:
    """Compare what was read with what is stored, record by record, floats exactly.

    A record that contradicts a stored one is added to `intake.problems`, unless `update`:
    then it replaces the stored one whole. A path that is stored without a row of its own
    (a profile came first) takes its row without `update`.
    """
    new = intake.records
    counts = {kind: Count() for kind in ("paths", "profiles", "events", "speeds")}
    bare = {path.path_id for path in stored.paths if path == Path(path.path_id)}
    write = Records(
        _changed(
            [(("path", p.path_id), p) for p in new.paths],
            {("path", p.path_id): p for p in stored.paths},
            counts["paths"],
            intake,
            update,
            {("path", path_id) for path_id in bare},
        ),
        _changed_profiles(new.profiles, stored.profiles, counts["profiles"], intake, update),
        _changed(
            [(("event", e.event_id), e) for e in new.events],
            {("event", e.event_id): e for e in stored.events},
            counts["events"],
            intake,
            update,
        ),
        _changed(
            [(speed_key(s), s) for s in new.speeds],
            {speed_key(s): s for s in stored.speeds},
            counts["speeds"],
            intake,
            update,
        ),
    )
    intake.problems = told_once(intake.problems)
    return Merge(write, counts)


def _changed(
    read: Sequence[tuple[Key, T]],
    stored: dict[Key, T],
    count: Count,
    intake: Intake,
    update: bool,
    replaceable: Iterable[Key] = (),
) -> tuple[T, ...]:
    write: list[T] = []
    free = set(replaceable)
    for key, record in read:
        old = stored.get(key)
        if old is None:
            count.new += 1
            write.append(record)
        elif not (changes := differences(record, old)):
            count.unchanged += 1
        elif update or key in free:
            count.updated += 1
            write.append(record)
        else:
            for column, value, held in changes:
                intake.refuse(key, column, _text(value), _as_stored(held))
    return tuple(write)


def _changed_profiles(
    read: Sequence[Profile], stored: Sequence[Profile], count: Count, intake: Intake, update: bool
) -> tuple[Profile, ...]:
    old = {profile.path_id: profile for profile in stored}
    write = []
    for profile in read:
        if profile.path_id not in old:
            count.new += 1
            write.append(profile)
        elif (change := profile_difference(profile, old[profile.path_id])) is None:
            count.unchanged += 1
        elif update:
            count.updated += 1
            write.append(profile)
        else:
            point, (column, value, held) = change
            where = f"{_as_stored(held)} (profile {profile.path_id}, point {point + 1})"
            intake.refuse(("profile", profile.path_id), column, _text(value), where)
    return tuple(write)


def _text(value: object) -> str:
    return "" if value is None else str(value)


def _as_stored(held: object) -> str:
    stored = "empty" if held is None else str(held)
    return f"{stored}, as stored before, or --update"
