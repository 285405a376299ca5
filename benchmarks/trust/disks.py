"""Disks that fill, folders that cannot be written to or vanish, clocks that jump."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.study import Line, bullets, table
from benchmarks.trust.commands import (
    JOBS,
    PROGRAM,
    Job,
    Ran,
    ended,
    link_records,
    make_state,
    start,
    write_records,
)
from benchmarks.trust.kills import Undisturbed, judge
from benchmarks.trust.places import Files, contents, copied
from benchmarks.trust.power import HERE, build

# A disk of its own for the command: a file system in memory that no other process sees.
MOUNTED = """
mount -t tmpfs -o size={size}k none mounted && cp -RP given/. mounted && cd mounted || exit 99
mount -o remount,{how} . || exit 99
{program} --db avahazard.db {words}
status=$?
cd .. && rm -rf given && mkdir given && cp -RP mounted/. given
exit $status
"""
DAY_S = 86_400
PAGE = 4096
"""Bytes that a disk in memory gives out at once."""


@dataclass(slots=True)
class Disturbed:
    """What came of a command on a bad disk or by a bad clock."""

    fault: str
    job: str
    told: bool
    faults: list[str] = field(default_factory=list)


def disks(given: Any, folder: Path) -> Line:
    """Full disks, read-only and vanishing folders, clocks that jump."""
    write_records(folder)
    found = []
    for one in disturb(JOBS, given.sizes, np.random.default_rng(given.seed), folder):
        print(f"{one.fault}: {one.job}, {'told' if one.told else 'done'} {one.faults}")
        found.append(one)
    told = Counter(one.fault for one in found if one.told)
    rows = [
        {"fault": kind, "commands": n, "told": told[kind]}
        for kind, n in Counter(one.fault for one in found).items()
    ]
    wrong = [f"{one.fault}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "mounted": can_mount(), "faults": wrong}


def page(found: Line) -> str:
    """How many commands ended by a message."""
    rows = [(row["fault"], row["commands"], row["told"]) for row in found["rows"]]
    return (
        table(("fault", "commands", "ended by a message"), rows)
        + ("" if found["mounted"] else "\n\nNo disk could be mounted on this machine.")
        + "\n\n"
        + bullets(
            found["faults"], "No traceback, no message without a remedy, no incomplete result."
        )
    )


def can_mount() -> bool:
    """Whether file systems of one's own can be mounted here."""
    if shutil.which("unshare") is None or os.geteuid() != 0:
        return False
    return subprocess.run(["unshare", "-m", "true"], check=False).returncode == 0


def disturb(
    jobs: Sequence[Job], n_sizes: int, rng: np.random.Generator, folder: Path
) -> Iterator[Disturbed]:
    """Run each job on bad disks and by bad clocks.

    Disks of `n_sizes` sizes, one that is read only, a folder that vanishes, clocks that jump.
    """
    states: dict[str, str] = {}
    for job in jobs:
        if job.state not in states:
            inside = folder / f"state-{job.state}"
            inside.mkdir()
            states[job.state] = Files().new(inside)
            make_state(job.state, states[job.state], folder)
        alone = leave_alone(job, states[job.state], folder)
        if can_mount():
            for _ in range(n_sizes):
                yield on_mounted(job, alone, folder, int(rng.integers(0, alone.written_kb + 1)))
            yield on_mounted(job, alone, folder, None)
        yield _vanishing(job, alone, folder, float(rng.uniform(0.3, 1.0)))
        for jump in (-3650 * DAY_S, 3650 * DAY_S):
            yield _jumping(job, alone, folder, jump)


def leave_alone(job: Job, start_database: str, folder: Path) -> Undisturbed:
    """Run a job on a file, in a process of its own, from its start to its end."""
    inside = folder / "alone"
    with copied(Files(), start_database, inside) as database:
        link_records(folder, inside)
        # Who holds the log keeps it there, as long as it ever was.
        with closing(sqlite3.connect(database)) as holder:
            holder.execute("SELECT count(*) FROM sqlite_schema").fetchone()
            size, began = _size(inside), time.monotonic()
            ended(start(database, job.words, inside), job.words).check()
            seconds, grown = time.monotonic() - began, _size(inside) - size
        file = (inside / job.file).read_bytes() if job.file else None
        before, after = contents(start_database), contents(database)
        return Undisturbed(start_database, before, after, file, seconds, written_kb=grown // 1024)


def _size(folder: Path) -> int:
    return sum(entry.stat(follow_symlinks=False).st_size for entry in os.scandir(folder))


def _given(alone: Undisturbed, folder: Path) -> Path:
    shutil.rmtree(folder / "disk", ignore_errors=True)
    given = folder / "disk" / "given"
    given.mkdir(parents=True)
    (folder / "disk" / "mounted").mkdir()
    shutil.copy(alone.start, given / "avahazard.db")
    return link_records(folder, given)


def on_mounted(job: Job, alone: Undisturbed, folder: Path, free_kb: int | None) -> Disturbed:
    """Run a job on a disk with that much room, or on a read-only one."""
    given = _given(alone, folder)
    # What is there already must fit, page by page.
    there = sum(-(-file.lstat().st_size // PAGE) * PAGE for file in given.rglob("*"))
    room = there // 1024 + (8192 if free_kb is None else free_kb)
    how = "ro" if free_kb is None else "rw"
    words = " ".join(f"'{word}'" for word in job.words)
    script = MOUNTED.format(size=room, how=how, program=PROGRAM, words=words)
    process = subprocess.Popen(
        ["unshare", "-m", "sh", "-c", script], cwd=folder / "disk", stdout=-1, stderr=-1, text=True
    )
    ran = ended(process, job.words)
    fault = "full disk" if how == "rw" else "read-only folder"
    return _judged(fault, job, alone, given, ran)


def _vanishing(job: Job, alone: Undisturbed, folder: Path, share: float) -> Disturbed:
    """Take the folder away after that share of the time that the job needs."""
    given, away = _given(alone, folder), folder / "disk" / "away"
    process = start(str(given / "avahazard.db"), job.words, given)
    timer = threading.Timer(share * alone.seconds, lambda: given.rename(away))
    timer.start()
    ran = ended(process, job.words)
    timer.join()
    away.rename(given)
    return _judged("folder that vanishes", job, alone, given, ran, confirmed=False)


def _jumping(job: Job, alone: Undisturbed, folder: Path, jump: int) -> Disturbed:
    """Run a job by a clock that jumps to and fro at every third reading."""
    given = _given(alone, folder)
    clock = {"LD_PRELOAD": str(build(HERE / "clock.c", folder)), "TRUST_EVERY": "3"}
    environment = {**os.environ, **clock, "TRUST_JUMP": str(jump)}
    process = start(str(given / "avahazard.db"), job.words, given, env=environment)
    ran = ended(process, job.words)
    found = _judged("clock that jumps", job, alone, given, ran)
    # Ten years back the last records of the dataset are in the future, with a message.
    if ran.status != 0 and "date" not in ran.errors:
        found.faults.append(f"refused: {ran.errors}")
    return found


def _judged(
    fault: str, job: Job, alone: Undisturbed, given: Path, ran: Ran, *, confirmed: bool = True
) -> Disturbed:
    found = Disturbed(fault, job.name, ran.status != 0)
    if ran.status not in (0, 1) or ran.discontinuous:
        found.faults.append(f"status {ran.status}: {ran.errors[-400:]}")
    elif ran.status == 1 and not ("Error:" in ran.errors and "Hint:" in ran.errors):
        found.faults.append(f"no message with a hint: {ran.errors[-400:]}")
    if job.file is not None and list(given.glob("*.part*")):
        found.faults.append("a part of a file is left")
    done = confirmed and ran.status == 0
    found.faults += judge(job, alone, str(given / "avahazard.db"), given, confirmed=done)[1]
    return found
