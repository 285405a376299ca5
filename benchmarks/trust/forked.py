"""A command in a process forked off this one, in which the program is loaded and warm already.

Such a process does from its first moment what the command is for, so that it can be killed there.
It tells of each statement that it sends within a transaction that writes, and of its commit.
"""

from __future__ import annotations

import contextlib
import os
import select
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, event
from sqlalchemy.engine import Engine

from benchmarks.trust.running import run


@dataclass(slots=True)
class Forked:
    """A running command; each byte on `told` is a statement that it is about to send."""

    pid: int
    told: int
    status: int | None = None

    def ended(self) -> bool:
        """Whether it has ended, as `status` then says; a signal counts negative."""
        if self.status is None:
            pid, found = os.waitpid(self.pid, os.WNOHANG)
            self.status = os.waitstatus_to_exitcode(found) if pid else None
        return self.status is not None

    def end(self, signal: int | None = None) -> None:
        """Wait for its end, after a `signal` if one is given."""
        if not self.ended():
            if signal is not None:
                os.kill(self.pid, signal)
            self.status = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        os.close(self.told)

    def await_statements(self, n: int) -> None:
        """Return when `n` statements have been told of, or it has ended."""
        while n > 0 and (read := os.read(self.told, n)):
            n -= len(read)

    def count_statements(self) -> int:
        """Wait for its end, and return how many statements it told of."""
        n = 0
        while read := os.read(self.told, 65536):
            n += len(read)
        self.end()
        return n

    def sleep(self, seconds: float) -> None:
        """Let it go on for that long, or until it ends."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0 and not self.ended():
            select.select([], [], [], min(left, 0.002))


def fork(database: str, words: tuple[str, ...], folder: Path) -> Forked:
    """Start a command from `folder`."""
    told, tell = os.pipe()
    pid = os.fork()
    if pid:
        os.close(tell)
        return Forked(pid, told)
    status = 70
    with contextlib.suppress(BaseException):
        os.close(told)
        event.listen(Engine, "before_cursor_execute", lambda c, *_: _tell(tell, c))
        event.listen(Engine, "commit", lambda c: _tell(tell, c))
        status = run(database, words, folder).status
    os._exit(status)


def _tell(told: int, connection: Connection, *_: Any) -> None:
    if connection.get_execution_options().get("writes", False):
        os.write(told, b".")
