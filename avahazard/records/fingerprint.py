"""A fingerprint of the data that a result stands on."""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from avahazard.records.collection import Event, Path, Profile, Records, Speed

KINDS = ("paths", "profiles", "events", "speeds")
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
    of the records: the same data imported in another order have the same fingerprint. Lines wait
    in a temporary database, which goes to the disk where it is large, and sorts them.
    """

    def __init__(self) -> None:
        self._lines = sqlite3.connect("")
        self._lines.execute("CREATE TABLE line (kind TEXT, text TEXT)")

    def add(self, records: Records) -> bytes:
        """Add a piece, and return its own digest, which depends on the order in it."""
        own = hashlib.sha256()

        def lines() -> Iterator[tuple[str, str]]:
            for kind in KINDS:
                for record in getattr(records, kind):
                    text = _line(record)
                    own.update(f"{kind} {text}\n".encode())
                    yield kind, text

        self._lines.executemany("INSERT INTO line VALUES (?, ?)", lines())
        return own.digest()

    def hexdigest(self) -> str:
        """The fingerprint of all pieces."""
        digest = hashlib.sha256()
        for kind in KINDS:
            of_kind = "FROM line WHERE kind = ?"
            (n,) = self._lines.execute(f"SELECT count(*) {of_kind}", (kind,)).fetchone()
            digest.update(f"{kind} {n}\n".encode())
            for (text,) in self._lines.execute(f"SELECT text {of_kind} ORDER BY text", (kind,)):
                digest.update(f"{text}\n".encode())
        return digest.hexdigest()


def _line(record: Path | Profile | Event | Speed) -> str:
    # Not `asdict`, which copies all that is in it.
    values = {name: getattr(record, name) for name in _COLUMNS[type(record)]}
    # Records from before this column was have the fingerprint that they had.
    if values.get("h_over_l", 0.0) is None:
        del values["h_over_l"]
    return _AS_TEXT.encode(_exact(values))


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
