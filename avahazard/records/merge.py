"""Records just read against the records stored before, number by number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

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


KEYS: dict[str, Callable[[Any], Key]] = {
    "paths": lambda path: ("path", path.path_id),
    "profiles": lambda profile: ("profile", profile.path_id),
    "events": lambda event: ("event", event.event_id),
    "speeds": speed_key,
}
"""What identifies a record of each kind."""


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
    counts = {kind: Count() for kind in KEYS}
    write: dict[str, list[Any]] = {kind: [] for kind in KEYS}
    for kind, count in counts.items():
        held = {KEYS[kind](record): record for record in getattr(stored, kind)}
        for record in getattr(intake.records, kind):
            key = KEYS[kind](record)
            old = held.get(key)
            changes = [] if old is None else _contradictions(record, old)
            if old is None:
                count.new += 1
            elif not changes:
                count.unchanged += 1
                continue
            elif update or old == Path(str(key[1])):
                count.updated += 1
            else:
                for column, value, accepted in changes:
                    intake.refuse(key, column, value, accepted)
                continue
            write[kind].append(record)
    intake.problems = told_once(intake.problems)
    return Merge(Records(*map(tuple, write.values())), counts)


def _contradictions(record: Any, old: Any) -> list[tuple[str, str, str]]:
    """Each column with the value read, and what is stored instead."""
    where = ""
    if isinstance(record, Profile):
        change = profile_difference(record, old)
        where = f" (profile {record.path_id}, point {change[0] + 1})" if change else ""
        found = [change[1]] if change else []
    else:
        found = differences(record, old)
    stored = "{}, as stored before, or --update{}"
    return [
        (
            column,
            "" if value is None else str(value),
            stored.format("empty" if held is None else held, where),
        )
        for column, value, held in found
    ]
