"""A fingerprint of the data that a result stands on."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import fields
from heapq import merge
from typing import IO

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

HELD_BYTES = 8_000_000
"""Bytes of lines that are held; what is more waits in files, sorted."""
MOST_FILES = 64
"""Files that are open at a time: where there are more, they become one."""


class SortedLines:
    """Lines that are added one by one and read once, sorted, each with its end.

    They are ASCII, and hold no character under a space (JSON does not).
    """

    def __init__(self) -> None:
        self.count = 0
        self._held: list[bytes] = []
        self._size = 0
        self._files: list[IO[bytes]] = []

    def add(self, line: str) -> None:
        """Add a line, without its end."""
        self.count += 1
        self._held.append(line.encode("ascii") + b"\n")
        self._size += len(line)
        if self._size > HELD_BYTES:
            self._put_away()

    def read(self) -> Iterator[bytes]:
        """The lines, sorted; they are gone then."""
        self._held.sort()
        try:
            yield from merge(*self._files, self._held)
        finally:
            self._close()
            self._held, self._size, self.count = [], 0, 0

    def _put_away(self) -> None:
        self._held.sort()
        lines: Iterable[bytes] = self._held
        full = len(self._files) == MOST_FILES
        if full:
            lines = merge(*self._files, lines)
        file = tempfile.TemporaryFile(prefix="avahazard-")  # noqa: SIM115 (closed when it is read)
        file.writelines(lines)
        file.seek(0)
        if full:
            self._close()
        self._files.append(file)
        self._held, self._size = [], 0

    def _close(self) -> None:
        for file in self._files:
            file.close()
        self._files = []


FINGERPRINT = "fingerprint"
"""Under this name it is kept with the records."""
_COLUMNS = {kind: [f.name for f in fields(kind)] for kind in (Path, Profile, Event, Speed)}
_AS_TEXT = json.JSONEncoder(sort_keys=True)


def data_fingerprint(records: Records) -> str:
    """Return the SHA-256 of `records` in hexadecimal (`Fingerprint`)."""
    if FINGERPRINT not in records.kept:
        whole = Fingerprint()
        whole.add(records)
        records.kept[FINGERPRINT] = whole.hexdigest()
    return str(records.kept[FINGERPRINT])


class Fingerprint:
    """The fingerprint of records that are added piece by piece, in any order.

    It depends on what is recorded only, to the last bit of every number, not on the order
    of the records: the same data imported in another order have the same fingerprint. Few of
    the records are held at a time.
    """

    def __init__(self) -> None:
        self._lines = {kind: SortedLines() for kind in ("paths", "profiles", "events", "speeds")}

    def add(self, records: Records) -> bytes:
        """Add a piece, and return its own digest, which depends on the order in it."""
        own = hashlib.sha256()
        for kind, texts in (
            ("paths", map(_line, records.paths)),
            ("profiles", map(_line, records.profiles)),
            ("events", map(_event_line, records.events)),
            ("speeds", map(_line, records.speeds)),
        ):
            for text in texts:
                own.update(f"{kind} {text}\n".encode())
                self._lines[kind].add(text)
        return own.digest()

    def hexdigest(self) -> str:
        """The fingerprint of all pieces, once all are added."""
        digest = hashlib.sha256()
        for kind, lines in self._lines.items():
            digest.update(f"{kind} {lines.count}\n".encode())
            for line in lines.read():
                digest.update(line)
        return digest.hexdigest()


def _line(record: Path | Profile | Speed) -> str:
    return _AS_TEXT.encode(_exact(_told(record)))


def _event_line(event: Event) -> str:
    values = _told(event)
    # Records from before this column was have the fingerprint that they had.
    if event.h_over_l is None:
        del values["h_over_l"]
    return _AS_TEXT.encode(_exact(values))


def _told(record: Path | Profile | Event | Speed) -> dict[str, object]:
    # Not `asdict`, which copies all that is in it.
    return {name: getattr(record, name) for name in _COLUMNS[type(record)]}


def _exact(value: object) -> object:
    """Write every number as a hexadecimal float, and 0 for -0, which a database does not keep."""
    if isinstance(value, float):
        return (value + 0.0).hex()
    if isinstance(value, dict):
        # Most of what there is are words and gaps.
        return {
            key: item if item is None or type(item) is str else _exact(item)
            for key, item in value.items()
        }
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return [*map(float.hex, (value + 0.0).tolist())]
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [item if type(item) is str else _exact(item) for item in value]
    return value
