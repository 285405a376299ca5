"""kill -9 at random moments: what was confirmed is there, the rest is all or nothing."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from avahazard.workflow.database import check
from benchmarks.trust.alone import Undisturbed, leave_alone_warm, link_records
from benchmarks.trust.forked import fork
from benchmarks.trust.jobs import Job, make_state
from benchmarks.trust.places import Files, Place, copied
from benchmarks.trust.rows import contents, faults, same_rows
from benchmarks.trust.running import run


@dataclass(slots=True)
class Killed:
    """What came of one kill; `faults` are what was lost, half stored, damaged or refused."""

    job: str
    place: str
    moment: float
    stood: str = "before"
    faults: list[str] = field(default_factory=list)


def kill_jobs(
    jobs: Sequence[Job], place: Place, n_kills: int, rng: np.random.Generator, folder: Path
) -> Iterator[Killed]:
    """Kill the jobs in turn, `n_kills` times in all; `folder` holds their records."""
    states: dict[str, str] = {}
    alone: dict[str, Undisturbed] = {}
    mine = [job for job in jobs if job.on_server or isinstance(place, Files)]
    try:
        for k in range(n_kills):
            job = mine[k % len(mine)]
            if job.state not in states:
                inside = folder / f"state-{job.state}"
                inside.mkdir()
                states[job.state] = place.new(inside)
                make_state(job.state, states[job.state], folder)
            if job.name not in alone:
                alone[job.name] = leave_alone_warm(job, place, states[job.state], folder)
            yield kill_once(job, place, alone[job.name], rng, folder)
    finally:
        for database in states.values():
            place.drop(database)


def kill_once(
    job: Job, place: Place, alone: Undisturbed, rng: np.random.Generator, folder: Path
) -> Killed:
    """Kill a job at a random moment, look at what is left, and run it again.

    Every second kill comes within 5 ms of a random one of the statements by which it writes.
    """
    inside = folder / "killed"
    with copied(place, alone.start, inside) as database:
        link_records(folder, inside)
        began = time.monotonic()
        process = fork(database, job.words, inside)
        if alone.n_statements and rng.random() < 0.5:
            process.await_statements(int(rng.integers(1, alone.n_statements + 1)))
            process.sleep(float(rng.uniform(0.0, 0.005)))
        else:
            process.sleep(float(rng.uniform(0.0, 1.05 * alone.seconds)))
        process.end(signal.SIGKILL)
        found = Killed(job.name, place.name, time.monotonic() - began)
        place.settle(database)
        _judge(found, job, alone, database, inside, confirmed=process.status == 0)
    return found


def _judge(
    found: Killed, job: Job, alone: Undisturbed, database: str, folder: Path, *, confirmed: bool
) -> None:
    now = contents(database)
    found.faults += faults(now, alone.before, alone.after)
    whole = now == alone.after
    found.stood = "after" if whole else "before" if now == alone.before else "between"
    if confirmed and not whole:
        found.faults.append("it was confirmed, and is not there")
    if job.file is not None and (folder / job.file).exists() and not _same_file(job, alone, folder):
        found.faults.append(f"{job.file} is written in part")
    if job.state != "old" or whole:
        found.faults += check(database, full=True).problems
    if job.file is not None and (folder / job.file).exists():
        (folder / job.file).unlink()  # backups are never written over
    again = run(database, job.words, folder)
    stored_already = whole and again.status == 1 and not again.broken
    if again.status != 0 and not stored_already:
        found.faults.append(f"the same command again: {again.errors or again.broken}")
    if not same_rows(contents(database), alone.after):
        found.faults.append("the same command again does not end as the one left alone")
    found.faults += check(database, full=True).problems


def _same_file(job: Job, alone: Undisturbed, folder: Path) -> bool:
    if job.file == "copy.db":  # stamped by the hour of the copy
        return contents(str(folder / job.file)) == alone.before
    return (folder / str(job.file)).read_bytes() == alone.written
