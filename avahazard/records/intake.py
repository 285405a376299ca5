"""What a call of import has read so far: records, where each stood, and what is wrong."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from avahazard.records.collection import Records
from avahazard.records.errors import RowProblem
from avahazard.records.event import Speed
from avahazard.records.path import TerrainCrop
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


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """The lines of a file as rows of `paths.csv` and `profiles.csv`.

    Each with the number of its feature in the place of a line number; the ground around them; and
    what is wrong with them.
    """

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
    problems: list[RowProblem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    read: list[str] = field(default_factory=list)
    understood: list[UnderstoodColumn] = field(default_factory=list)
    known: Records = field(default_factory=Records)

    def claim(self, key: Key, origin: Origin, column: str, value: str) -> bool:
        """Take `key` for the row at `origin`; a second row with it is a problem."""
        if key in self.origins:
            file, line = self.origins[key]
            accepted = f"each one once: it is also in {file}, line {line}"
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
