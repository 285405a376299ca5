"""Progress of long computations on standard error, with the time that is left."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Report = Callable[[str, float, float], None]

PATIENCE_S = 2.0
LINE_EVERY_S = 10.0


@contextmanager
def show_progress() -> Iterator[Report]:
    """Give a function `report(what, done, total)` for a use case to call as it goes on.

    Nothing is shown for what takes less than two seconds. A terminal then gets a bar; a
    log file gets a line now and then.
    """
    display = _Bar() if sys.stderr.isatty() else _Lines()
    try:
        yield display.report
    finally:
        display.close()


class _Bar:
    def __init__(self) -> None:
        self.started = time.monotonic()
        self.progress: Progress | None = None
        self.tasks: dict[str, TaskID] = {}

    def report(self, what: str, done: float, total: float) -> None:
        if self.progress is None:
            if time.monotonic() - self.started < PATIENCE_S:
                return
            self.progress = _rich_progress()
            self.progress.start()
        if what not in self.tasks:
            self.tasks[what] = self.progress.add_task(what, total=total)
        self.progress.update(self.tasks[what], completed=done, total=total)

    def close(self) -> None:
        if self.progress is not None:
            self.progress.stop()


class _Lines:
    def __init__(self) -> None:
        self.started: dict[str, float] = {}
        self.said = time.monotonic() + PATIENCE_S - LINE_EVERY_S

    def report(self, what: str, done: float, total: float) -> None:
        now = time.monotonic()
        started = self.started.setdefault(what, now)
        if now - self.said < LINE_EVERY_S or total <= 0:
            return
        self.said = now
        share = done / total
        left = f", {(now - started) * (1 - share) / share:.0f} s left" if share > 0 else ""
        print(f"{what}: {share:.0%}{left}", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Nothing is open."""


def _rich_progress() -> Progress:
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import (  # noqa: PLC0415
        BarColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
