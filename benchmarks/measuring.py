"""How two sides are measured against each other: A B A B in one run, medians of ratios."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from statistics import median
from typing import Any

from benchmarks.study import ROOT

Row = tuple[float, float, float, str]
"""What a case measures: the ratio that has a target, ours, theirs, and a note."""


def alternate(
    ours: Callable[[], float], theirs: Callable[[], float], rounds: int
) -> tuple[float, float, float]:
    """Median of theirs / ours round by round, and of what each gives, after a first round."""
    ours(), theirs()
    pairs = [(ours(), theirs()) for _ in range(rounds)]
    a, b = zip(*pairs, strict=True)
    return median(theirs / ours for ours, theirs in pairs), median(a), median(b)


def seconds(
    work: Callable[[], object], repeats: int = 1, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Seconds that one call takes, the mean of `repeats` calls in a row."""
    start = clock()
    for _ in range(repeats):
        work()
    return (clock() - start) / repeats


def processor_seconds(work: Callable[[], object], repeats: int = 1) -> float:
    """The same in seconds of all processors, which other work does not lengthen."""
    return seconds(work, repeats, time.process_time)


def processes(ours: Sequence[str], theirs: Sequence[str], rounds: int = 15) -> Row:
    """Two commands as whole processes: ours / theirs, and the seconds of each."""

    def process(command: Sequence[str]) -> float:
        return seconds(lambda: subprocess.run(command, stdout=subprocess.DEVNULL, check=True))

    inverse, a, b = alternate(lambda: process(ours), lambda: process(theirs), rounds)
    return 1.0 / inverse, a, b, "whole processes; the smaller the better."


def alone(code: str, *arguments: str) -> Any:
    """What code prints as JSON, in a process of its own: nothing else is in its memory."""
    command = [sys.executable, "-c", code, *arguments]
    return json.loads(subprocess.run(command, cwd=ROOT, stdout=-1, check=True).stdout)


@contextlib.contextmanager
def all_cores() -> Iterator[None]:
    """All cores within; outside a case has one."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    yield
    os.sched_setaffinity(0, before)


def peak_mb() -> float:
    """Peak memory (MB) of this process so far.

    Not `ru_maxrss`, in which a new process keeps the peak of the one that started it.
    """
    with open("/proc/self/status", encoding="utf-8") as status:
        found = dict(line.split(":", 1) for line in status)
    return int(found["VmHWM"].split()[0]) / 1024
