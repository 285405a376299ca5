"""Progress of long computations on standard error, with the time that is left."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from avahazard.results.base import Report, silent

if TYPE_CHECKING:
    from rich.progress import Progress


PATIENCE_S = 2.0
LINE_EVERY_S = 10.0
KNOWN_FROM = 0.05
"""The time that is left is told from this share on: before, it is a guess."""


@contextmanager
def show_progress(*, log: bool = True) -> Iterator[Report]:
    """Give a function `report(what, done, total)` for a use case to call as it goes on.

    Nothing is shown for what takes less than two seconds. A terminal or a notebook then gets one
    bar, which says what is being done; a log file gets a line now and then, unless `log` is false.
    """
    if not (log or sys.stderr.isatty() or "ipykernel" in sys.modules):
        yield silent
        return
    display = _Bar() if sys.stderr.isatty() or "ipykernel" in sys.modules else _Lines()
    try:
        yield display.report
    finally:
        display.close()


class _Clock:
    """The share that is done, and the time that is left; a share that falls back starts anew."""

    def __init__(self) -> None:
        self.started: float | None = None
        self.share = 0.0

    def left_s(self, share: float) -> float | None:
        """Seconds that are left at this share, None before that is known."""
        now = time.monotonic()
        if self.started is None or share < self.share:
            self.started = now
        self.share = share
        if share < KNOWN_FROM or now == self.started:
            return None
        return (now - self.started) * (1.0 - share) / share


class _Bar:
    def __init__(self) -> None:
        self.began = time.monotonic()
        self.clock = _Clock()
        self.progress: Progress | None = None

    def report(self, what: str, done: float, total: float) -> None:
        share = done / total if total > 0 else 0.0
        left = self.clock.left_s(share)
        if self.progress is None:
            if time.monotonic() - self.began < PATIENCE_S:
                return
            self.progress = _rich_progress()
            self.progress.add_task(what, total=1.0, percent="", left="")
            self.progress.start()
        task = self.progress.task_ids[0]
        words = "" if left is None else f"{left:.0f} s left"
        self.progress.update(
            task, description=what, completed=share, percent=_percent(share), left=words
        )

    def close(self) -> None:
        if self.progress is not None:
            self.progress.stop()


class _Lines:
    def __init__(self) -> None:
        self.clock = _Clock()
        self.said = time.monotonic() + PATIENCE_S - LINE_EVERY_S

    def report(self, what: str, done: float, total: float) -> None:
        share = done / total if total > 0 else 0.0
        left = self.clock.left_s(share)
        now = time.monotonic()
        if now - self.said < LINE_EVERY_S or total <= 0:
            return
        self.said = now
        words = "" if left is None else f", {left:.0f} s left"
        print(f"{what}: {_percent(share)}%{words}", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Nothing is open."""


def _percent(share: float) -> int:
    """Whole percents that are done: 100 only at the end."""
    return int(100.0 * share + 1e-9)


def _rich_progress() -> Progress:
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn  # noqa: PLC0415

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[percent]:>3} %"),
        TextColumn("{task.fields[left]}"),
        console=Console(stderr=True),
        transient=True,
    )
