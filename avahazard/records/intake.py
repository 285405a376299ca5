"""What a call of import has read: records, where each stood, what is wrong, what is stored."""

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from avahazard.records.collection import Event, Path, Profile, Records, Speed, TerrainCrop
from avahazard.records.errors import Problems, RowProblem, told_once
from avahazard.records.table import FileTable

Key = tuple[Hashable, ...]  # the kind of a record, and what identifies it
Origin = tuple[str, int]  # file and line


@dataclass(frozen=True, slots=True)
class UnderstoodColumn:
    """A column of a file: its name there, what it means, its unit, its first values as read."""

    file: str
    form: str
    column: str
    meaning: str
    unit: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Guess:
    """What a column of a file seems to be, why, and how sure that is (0 to 1).

    `classes` are words of the file for values that are known.
    """

    table: str
    column: str
    source: str
    unit: str
    reason: str
    confidence: float
    ranges: bool
    classes: dict[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Lines of a file as rows of `paths.csv` and `profiles.csv`, by feature, and their ground."""

    file: str
    paths: FileTable
    profiles: FileTable
    terrain: tuple[TerrainCrop, ...]
    problems: tuple[RowProblem, ...]
    notes: tuple[str, ...]


@dataclass
class Intake:
    """Records in the order of the files; `origins` has no path that only a profile implies.

    `read` says in a line how each file was read, `understood` how each column was. `known` are
    the records stored before, with the profiles of the paths that it touches.
    """

    files: list[str] = field(default_factory=list)
    records: Records = field(default_factory=Records)
    origins: dict[Key, Origin] = field(default_factory=dict)
    problems: Problems = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    read: list[str] = field(default_factory=list)
    understood: list[UnderstoodColumn] = field(default_factory=list)
    known: Records = field(default_factory=Records)

    def claim(self, key: Key, origin: Origin, column: str, value: str) -> bool:
        """Take `key` for the row at `origin`; a second row with it is a problem."""
        if key in self.origins:
            file, line = self.origins[key]
            accepted = f"each one once: it is also in {file}, line {line}"
            if key[0] == "speed":
                accepted += "; of several readings at one place give the mean"
            self.problems.append(RowProblem(*origin, column, value, accepted))
            return False
        self.origins[key] = origin
        return True

    def refuse(self, key: Key, column: str, value: object, accepted: str) -> None:
        """Add a problem at the row of the record `key`, or at the stored one, by its name."""
        text = f"{value:g}" if isinstance(value, float) else str(value)
        kind = {"speed": "a speed of event"}.get(str(key[0]), key[0])
        file, line = self.origins.get(key, (f"the database, {kind} {key[1]}", 0))
        self.problems.append(RowProblem(file, line, column, text, accepted))


def speed_key(speed: Speed) -> Key:
    """Identify a speed: one event has one speed at one place."""
    return ("speed", speed.event_id, speed.x_m, speed.elevation_m)


Difference = tuple[str, object, object]  # column, one value, the other value


def differences(one: Path | Event | Speed, other: Path | Event | Speed) -> list[Difference]:
    """Return the columns in which `one` and `other` differ; numbers are compared exactly."""
    left, right = (
        {f.name: getattr(record, f.name) for f in fields(record) if f.name != "covariates"}
        | dict(getattr(record, "covariates", {}))
        for record in (one, other)
    )
    return [(c, left.get(c), right.get(c)) for c in left | right if left.get(c) != right.get(c)]


def profile_difference(one: Profile, other: Profile) -> tuple[int, Difference] | None:
    """Return the first point at which two profiles differ and how, None when they are equal."""
    n = min(len(one.x_m), len(other.x_m))
    found: list[tuple[int, Difference]] = []
    for name in (f.name for f in fields(Profile) if f.name != "path_id"):
        # What a profile lacks, or has once, is the same at all points.
        given = (np.atleast_1d(np.asarray(getattr(profile, name))) for profile in (one, other))
        left, right = np.broadcast_arrays(*(values[:n] for values in given))
        first = np.flatnonzero(left != right)[:1].tolist()
        found += [(k, (name, left[k], right[k])) for k in first]
    if not found and len(one.x_m) != len(other.x_m):
        found = [(n - 1, ("path_id", f"{len(one.x_m)} points", f"{len(other.x_m)} points"))]
    return min(found, key=lambda difference: difference[0], default=None)


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


def merge_records(intake: Intake, *, update: bool = False) -> tuple[Records, dict[str, Count]]:
    """What has to be written of what was read, and counts by kind; floats are compared exactly.

    A record that contradicts a stored one is added to `intake.problems`, unless `update`:
    then it replaces the stored one whole. A path that is stored without a row of its own
    (a profile came first) takes its row without `update`.
    """
    counts = {kind: Count() for kind in KEYS}
    write: dict[str, list[Any]] = {kind: [] for kind in KEYS}
    for kind, count in counts.items():
        held = {KEYS[kind](record): record for record in getattr(intake.known, kind)}
        for record in getattr(intake.records, kind):
            key = KEYS[kind](record)
            old = held.get(key)
            changes = [] if old is None else list(_contradictions(record, old))
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
    return Records(*map(tuple, write.values())), counts


def _contradictions(record: Any, old: Any) -> Iterator[tuple[str, str, str]]:
    """Each column with the value read, and what is stored instead."""
    where = ""
    if isinstance(record, Profile):
        change = profile_difference(record, old)
        where = f" (profile {record.path_id}, point {change[0] + 1})" if change else ""
        found = [change[1]] if change else []
    else:
        found = differences(record, old)
    for column, value, held in found:
        accepted = f"{'empty' if held is None else held}, as stored before, or --update{where}"
        yield column, "" if value is None else str(value), accepted
