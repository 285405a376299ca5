"""How two sides are measured against each other: A B A B in one run, medians of ratios."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple


class Result(NamedTuple):
    """One row of the table; `ratio` is compared with `target`, `meaning` says which way."""

    ratio: float
    ours: float
    theirs: float
    unit: str
    target: float
    at_most: bool
    meaning: str
    note: str

    @property
    def reached(self) -> bool:
        """Whether the target is met."""
        return self.ratio <= self.target if self.at_most else self.ratio >= self.target


def alternate(
    ours: Callable[[], float], theirs: Callable[[], float], rounds: int
) -> tuple[float, float, float]:
    """Medians of what both give, and of theirs / ours round by round, after one round unseen."""
    ours(), theirs()
    pairs = [(ours(), theirs()) for _ in range(rounds)]
    a, b = zip(*pairs, strict=True)
    return median(a), median(b), median(theirs / ours for ours, theirs in pairs)


def seconds(work: Callable[[], object], repeats: int = 1) -> float:
    """Seconds that one call takes, the mean of `repeats` calls in a row."""
    start = time.perf_counter()
    for _ in range(repeats):
        work()
    return (time.perf_counter() - start) / repeats


def processor_seconds(work: Callable[[], object], repeats: int = 1) -> float:
    """The same in seconds of a processor, which other work on it does not lengthen."""
    start = time.process_time()
    for _ in range(repeats):
        work()
    return (time.process_time() - start) / repeats


def processes(
    ours: Sequence[str], theirs: Sequence[str], rounds: int = 15
) -> tuple[float, float, float]:
    """Medians of seconds of two commands, as whole processes, and of ours / theirs."""

    def process(command: Sequence[str]) -> float:
        return seconds(lambda: subprocess.run(command, stdout=subprocess.DEVNULL, check=True))

    a, b, inverse = alternate(lambda: process(ours), lambda: process(theirs), rounds)
    return a, b, 1.0 / inverse


def alone(code: str, *arguments: str) -> Any:
    """What code prints as JSON, in a process of its own: nothing else is in its memory."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=Path(__file__).resolve().parents[1],
        stdout=subprocess.PIPE,
        check=True,
    )
    return json.loads(done.stdout)


def peak_mb() -> float:
    """Peak memory (MB) of this process so far.

    Not `ru_maxrss`, in which a new process keeps the peak of the one that started it.
    """
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(dict(line.split(":", 1) for line in status.splitlines())["VmHWM"].split()[0]) / 1024
