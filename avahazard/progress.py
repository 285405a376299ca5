"""Progress of long computations on standard error, with the time that is left."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from avahazard.results.base import Report, silent

PATIENCE_S = 2.0
LINE_EVERY_S = 10.0
KNOWN_FROM = 0.1
"""The time that is left is shown from this share on: before, it is a guess."""


@contextmanager
def show_progress(*, log: bool = True) -> Iterator[Report]:
    """Give a function `report(what, share)` for a use case to call as it goes on.

    Nothing is shown for what takes less than two seconds. A terminal or a notebook then gets one
    bar, which says what is being done; a log file gets a line now and then, unless `log` is false.
    """
    if sys.stderr.isatty() or "ipykernel" in sys.modules:
        with _bar() as report:
            yield report
    else:
        yield _lines() if log else silent


class Clock:
    """The share to show, which never falls, and the time that is left.

    Where the reported share falls, another step has begun: it has the rest of the bar, and the time
    that is left is that of the step.
    """

    def __init__(self) -> None:
        self.started = self.base = self.shown = self.share = 0.0
        self.steps = 0

    def tell(self, share: float) -> tuple[float, str]:
        """The share to show, and what is left in words; no words while that is not known."""
        now, share = time.monotonic(), min(max(share, 0.0), 1.0)
        if not self.steps or share < self.share:
            self.started, self.base, self.steps = now, self.shown, self.steps + 1
        self.share = share
        self.shown = max(self.shown, self.base + (1.0 - self.base) * share)
        if share < KNOWN_FROM or now == self.started:
            return self.shown, ""
        left = (now - self.started) * (1.0 - share) / share
        return self.shown, f"{left:.0f} s left" + (" of this step" if self.steps > 1 else "")


@contextmanager
def _bar() -> Iterator[Report]:
    from rich.console import Console  # noqa: PLC0415 (slow)
    from rich.progress import BarColumn, Progress, TextColumn  # noqa: PLC0415

    clock, began = Clock(), time.monotonic()
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[percent]:>3} %"),
        TextColumn("{task.fields[left]}"),
        console=Console(stderr=True),
        transient=True,
    )
    task = bar.add_task("", total=1.0, percent="", left="")

    def report(what: str, share: float) -> None:
        share, words = clock.tell(share)
        bar.update(task, description=what, completed=share, percent=_percent(share), left=words)
        if not bar.live.is_started and time.monotonic() - began >= PATIENCE_S:
            bar.start()

    try:
        yield report
    finally:
        if bar.live.is_started:
            bar.stop()


def _lines() -> Report:
    clock, said = Clock(), time.monotonic() + PATIENCE_S - LINE_EVERY_S

    def report(what: str, share: float) -> None:
        nonlocal said
        share, words = clock.tell(share)
        now = time.monotonic()
        if now - said >= LINE_EVERY_S:
            said = now
            parts = filter(None, (f"{what}: {_percent(share)}%", words))
            print(", ".join(parts), file=sys.stderr, flush=True)

    return report


def _percent(share: float) -> int:
    """Whole percents that are done: 100 only at the end."""
    return int(100.0 * share + 1e-9)
