"""Lines of text in their order, of which few are held at a time."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from heapq import merge
from typing import IO

HELD_BYTES = 16_000_000
"""Bytes of lines that are held; what is more waits in files, sorted."""


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
            for file in self._files:
                file.close()
            self._held, self._files, self._size, self.count = [], [], 0, 0

    def _put_away(self) -> None:
        file = tempfile.TemporaryFile(prefix="avahazard-")  # noqa: SIM115 (closed when it is read)
        file.writelines(sorted(self._held))
        file.seek(0)
        self._files.append(file)
        self._held, self._size = [], 0
