"""Lines of text in their order, of which few are held at a time."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from heapq import merge
from typing import IO

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
