"""A job that is left alone: what it stores, what it takes, and what is held against it."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from benchmarks.trust.forked import fork
from benchmarks.trust.jobs import Job
from benchmarks.trust.places import Files, Place, copied
from benchmarks.trust.rows import Contents, contents
from benchmarks.trust.running import run, start


@dataclass(frozen=True, slots=True)
class Undisturbed:
    """A job that was left alone: the database before and after, its file, how long it took.

    `written_kb`: by how much its files grew at most, log and all (0 where that was not looked at).
    `n_statements`: those it sent within transactions that write, and their commits (as before).
    """

    start: str
    before: Contents
    after: Contents
    written: bytes | None
    seconds: float
    written_kb: int = 0
    n_statements: int = 0


def leave_alone(job: Job, start_database: str, folder: Path) -> Undisturbed:
    """Run a job on a file, in a process of its own, from its start to its end."""
    before = contents(start_database)
    inside = folder / "alone"
    with copied(Files(), start_database, inside) as database:
        link_records(folder, inside)
        # Who holds the log keeps it there, as long as it ever was.
        with closing(sqlite3.connect(database)) as holder:
            holder.execute("SELECT count(*) FROM sqlite_schema").fetchone()
            size = _size(inside)
            began = time.monotonic()
            process = start(database, job.words, inside, stderr=subprocess.PIPE)
            errors = process.communicate()[1]
            seconds = time.monotonic() - began
            if process.returncode != 0:
                raise SystemExit(f"{job.name} does not succeed when it is left alone: {errors}")
            grown = (_size(inside) - size) // 1024
        file = (inside / job.file).read_bytes() if job.file else None
        return Undisturbed(start_database, before, contents(database), file, seconds, grown)


def leave_alone_warm(job: Job, place: Place, start_database: str, folder: Path) -> Undisturbed:
    """Run a job in this process, which is warm then, and time it in one forked off."""
    before = contents(start_database)
    inside = folder / "alone"
    with copied(place, start_database, inside) as database:
        link_records(folder, inside)
        run(database, job.words, inside).check()
        after = contents(database)
        file = (inside / job.file).read_bytes() if job.file else None
    with copied(place, start_database, inside) as database:
        link_records(folder, inside)
        began = time.monotonic()
        forked = fork(database, job.words, inside)
        n_statements = forked.count_statements()
        seconds = time.monotonic() - began
        if forked.status != 0:
            raise SystemExit(f"{job.name} does not succeed in a process forked off")
    return Undisturbed(start_database, before, after, file, seconds, n_statements=n_statements)


def link_records(folder: Path, inside: Path) -> None:
    """Give a job in `inside` the records of `folder`."""
    for name in ("world", "changed"):
        (inside / name).symlink_to(folder / name)
    shutil.copy(folder / "avahazard.toml", inside)


def _size(folder: Path) -> int:
    return sum(entry.stat(follow_symlinks=False).st_size for entry in os.scandir(folder))
