"""What a disk may hold after a power cut, out of the log of `disk_log.c`.

A disk keeps what was synced. Of the writes to a file after its last sync it keeps none, all, or
any of them, each perhaps in part (512 bytes at a time). Files that were made, renamed or removed
since the last sync of anything come in their order, up to a moment that chance chooses.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

NUMBERS = struct.Struct("<qqq")
SECTOR = 512
Renaming = tuple[str, str, int]


class Step(NamedTuple):
    """A record of the log: see `disk_log.c`."""

    kind: str
    a: int
    b: int
    data: bytes


def steps_of(log: Path) -> list[Step]:
    """The records of a log, in their order."""
    data, at, found = log.read_bytes(), 0, []
    while at < len(data):
        kind = chr(data[at])
        a, b, n = NUMBERS.unpack_from(data, at + 1)
        at += 1 + NUMBERS.size
        found.append(Step(kind, a, b, data[at : at + n]))
        at += n
    return found


@dataclass
class Disk:
    """Files by number (`content`, and what is not synced yet), and their names.

    What is not synced carries the number of its step: a sync keeps what stood when it began.
    """

    content: dict[int, bytearray] = field(default_factory=dict)
    waiting: dict[int, list[tuple[int, Step]]] = field(default_factory=dict)
    names: dict[str, int] = field(default_factory=dict)
    unnamed: list[tuple[int, Renaming]] = field(default_factory=list)
    descriptors: dict[int, int] = field(default_factory=dict)
    began: dict[int, int] = field(default_factory=dict)
    taken: int = 0

    def names_now(self) -> dict[str, int]:
        """The names as the running processes see them."""
        return _renamed(self.names, self.unnamed)

    def take(self, step: Step) -> None:
        """Go one record on."""
        self.taken += 1
        if step.kind == "O":
            self._open(step)
        elif step.kind in "WT" and (file := self.descriptors.get(step.a)) is not None:
            self.waiting[file].append((self.taken, step))
        elif step.kind == "F":
            self.began[step.a] = self.taken
        elif step.kind == "S":
            self._sync(self.descriptors.get(step.a), self.began.pop(step.a, self.taken))
        elif step.kind == "P" and (file := self.names_now().get(step.data.decode())) is not None:
            self.waiting[file].append((self.taken, step._replace(kind="T")))
        elif step.kind == "U":
            self.unnamed.append((self.taken, ("remove", step.data.decode(), 0)))
        elif step.kind in "RL":
            self._name(step)

    def after_cut(self, how: str, rng: np.random.Generator) -> dict[str, bytes]:
        """The files by name, of the writes not synced yet `none`, `all`, or `some`."""
        n_names = int(rng.integers(len(self.unnamed) + 1))
        found = {}
        for name, file in _renamed(self.names, self.unnamed[:n_names]).items():
            content = bytearray(self.content[file])
            for _, step in self.waiting[file]:
                if how == "all" or (how == "some" and rng.random() < 0.5):
                    kept = step
                    if how == "some" and step.kind == "W" and rng.random() < 0.3:
                        n_sectors = int(rng.integers(len(step.data) // SECTOR + 1))
                        kept = step._replace(data=step.data[: n_sectors * SECTOR])
                    _apply(content, kept)
            found[name] = bytes(content)
        return found

    def _sync(self, file: int | None, began: int) -> None:
        self.names = _renamed(self.names, [one for one in self.unnamed if one[0] <= began])
        self.unnamed = [one for one in self.unnamed if one[0] > began]
        if file is None:
            return
        for number, one in self.waiting[file]:
            if number <= began:
                _apply(self.content[file], one)
        self.waiting[file] = [one for one in self.waiting[file] if one[0] > began]

    def _open(self, step: Step) -> None:
        name = step.data.decode()
        self.descriptors.pop(step.a, None)
        if step.b & os.O_DIRECTORY or Path(name).is_dir():
            return
        there = self.names_now()
        if name not in there:
            file = len(self.content)
            self.content[file], self.waiting[file] = bytearray(), []
            self.unnamed.append((self.taken, ("name", name, file)))
            there[name] = file
        self.descriptors[step.a] = there[name]
        if step.b & os.O_TRUNC:
            self.waiting[there[name]].append((self.taken, Step("T", step.a, 0, b"")))

    def _name(self, step: Step) -> None:
        old, new = step.data.decode().split("\0")
        file = self.names_now().get(old)
        if file is None:
            return  # made by the C library itself, whose calls are not intercepted: no data are
        self.unnamed.append((self.taken, ("name", new, file)))
        if step.kind == "R":
            self.unnamed.append((self.taken, ("remove", old, 0)))


def disk_of(folder: Path) -> Disk:
    """The disk before anything is done: the files below `folder`, all synced."""
    disk = Disk()
    for k, file in enumerate(sorted(f for f in folder.rglob("*") if f.is_file())):
        disk.content[k], disk.waiting[k] = bytearray(file.read_bytes()), []
        disk.names[str(file)] = k
    return disk


def confirmed(steps: list[Step]) -> Iterator[tuple[int, str]]:
    """Each line on standard output, with the record at which it was there."""
    for k, step in enumerate(steps):
        if step.kind == "C":
            for line in filter(None, step.data.decode().splitlines()):
                yield k, line


def _renamed(names: dict[str, int], changes: list[tuple[int, Renaming]]) -> dict[str, int]:
    found = dict(names)
    for _, (kind, name, file) in changes:
        if kind == "name":
            found[name] = file
        else:
            found.pop(name, None)
    return found


def _apply(content: bytearray, step: Step) -> None:
    if step.kind == "T":
        del content[step.b :]
        content.extend(bytes(step.b - len(content)))
    else:
        content.extend(bytes(max(0, step.b - len(content))))
        content[step.b : step.b + len(step.data)] = step.data
