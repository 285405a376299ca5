"""kill -9 at random moments: what was confirmed is there, the rest is all or nothing."""

from __future__ import annotations

import signal
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.workflow.database import check
from benchmarks.study import Line, bullets, table
from benchmarks.trust.commands import JOBS, Job, fork, link_records, make_state, run, write_records
from benchmarks.trust.places import (
    Contents,
    Files,
    Place,
    contents,
    copied,
    faults,
    places,
    same_rows,
)


@dataclass(frozen=True, slots=True)
class Undisturbed:
    """A job that was left alone: the database before and after, its file, how long it took.

    `n_statements`: those it sent within transactions that write, and their commits.
    `written_kb`: by how much its files grew at most, log and all.
    """

    start: str
    before: Contents
    after: Contents
    written: bytes | None
    seconds: float
    n_statements: int = 0
    written_kb: int = 0


@dataclass(slots=True)
class Killed:
    """What came of one kill; `faults` are what was lost, half stored, damaged or refused."""

    job: str
    place: str
    moment: float
    stood: str
    faults: list[str]


def kills(given: Any, folder: Path) -> Line:
    """kill -9 over all writing commands, shared among the databases."""
    write_records(folder)
    jobs = [job for job in JOBS if given.only in ("", job.name)]
    selected = [place for place in places() if isinstance(place, Files) or jobs[0].on_server]
    found = []
    for place in selected:
        rng = np.random.default_rng([given.seed, len(place.name)])
        inside = link_records(folder, folder / place.name)
        for one in kill_jobs(jobs, place, given.kills // len(selected), rng, inside):
            print(f"{place.name}: {one.job} after {one.moment:.1f} s, {one.stood} {one.faults}")
            found.append(one)
    rows = []
    for name, job in dict.fromkeys((one.place, one.job) for one in found):
        stood = Counter(one.stood for one in found if (one.place, one.job) == (name, job))
        rows.append({"place": name, "job": job, "kills": stood.total(), **stood})
    wrong = [f"{one.place}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "faults": wrong}


def page(runs: Sequence[Line]) -> str:
    """The kills of all seeds together."""
    rows = [row for run in runs for row in run["rows"]]
    columns = ("kills", "before", "between", "after")
    by_job = [
        (f"`{job}`", *(sum(r.get(k, 0) for r in rows if r["job"] == job) for k in columns))
        for job in dict.fromkeys(row["job"] for row in rows)
    ]
    wrong = [f"`{fault}`" for run in runs for fault in run["faults"]]
    return (
        f"{sum(row['kills'] for row in rows)} kills on "
        f"{' and '.join(dict.fromkeys(row['place'] for row in rows))}.\n\n"
        + table(("command", "kills", "state before", "partial", "state after"), by_job)
        + f"\n\n{len(wrong)} with a fault:\n\n"
        + bullets(wrong, "None.")
    )


def kill_jobs(
    jobs: Sequence[Job], place: Place, n_kills: int, rng: np.random.Generator, folder: Path
) -> Iterator[Killed]:
    """Kill the jobs in turn, `n_kills` times in all; `folder` holds their records."""
    states: dict[str, str] = {}
    alone: dict[str, Undisturbed] = {}
    selected = [job for job in jobs if job.on_server or isinstance(place, Files)]
    try:
        for k in range(n_kills):
            job = selected[k % len(selected)]
            if job.state not in states:
                inside = folder / f"state-{job.state}"
                inside.mkdir()
                states[job.state] = place.new(inside)
                make_state(job.state, states[job.state], folder)
            if job.name not in alone:
                alone[job.name] = _left_alone(job, place, states[job.state], folder)
            yield kill_once(job, place, alone[job.name], rng, folder)
    finally:
        for database in states.values():
            place.drop(database)


def _left_alone(job: Job, place: Place, start: str, folder: Path) -> Undisturbed:
    """Run a job in this process, which is warm then, and time it in one forked off."""
    inside = folder / "alone"
    with copied(place, start, inside) as database:
        run(database, job.words, link_records(folder, inside)).check()
        after = contents(database)
        file = (inside / job.file).read_bytes() if job.file else None
    with copied(place, start, inside) as database:
        began = time.monotonic()
        forked = fork(database, job.words, link_records(folder, inside))
        n_statements = forked.count_statements()
        if forked.status != 0:
            raise SystemExit(f"{job.name} does not succeed in a process forked off")
        seconds = time.monotonic() - began
    return Undisturbed(start, contents(start), after, file, seconds, n_statements)


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
        moment = time.monotonic() - began
        place.settle(database)
        stood, wrong = judge(job, alone, database, inside, confirmed=process.status == 0)
    return Killed(job.name, place.name, moment, stood, wrong)


def judge(
    job: Job, alone: Undisturbed, database: str, folder: Path, *, confirmed: bool
) -> tuple[str, list[str]]:
    """What a job left (as before, in between or as after), and what is wrong; then run it again."""
    now = contents(database)
    found = faults(now, alone.before, alone.after)
    whole = now == alone.after
    stood = "after" if whole else "before" if now == alone.before else "between"
    if confirmed and not whole:
        found.append("it was confirmed, and is not there")
    if job.state != "old" or whole:
        found += check(database, full=True).problems
    if job.file is not None and (file := folder / job.file).exists():
        if job.file == "copy.db":  # stamped by the hour of the copy
            same = contents(str(file)) == alone.before
        else:
            same = file.read_bytes() == alone.written
        if not same:
            found.append(f"{job.file} is written in part")
        file.unlink()  # backups are never written over
    again = run(database, job.words, folder)
    stored_already = whole and again.status == 1 and not again.discontinuous
    if again.status != 0 and not stored_already:
        found.append(f"the same command again: {again.errors or again.broken}")
    if not same_rows(contents(database), alone.after):
        found.append("the same command again does not end as the one left alone")
    return stood, found + list(check(database, full=True).problems)
