"""Power cuts: what was confirmed is there, when only what was synced has reached the disk."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avahazard.store import upkeep
from avahazard.workflow.database import check
from benchmarks.trust.disk_replay import confirmed, disk_of, steps_of

HERE = Path(__file__).resolve().parent
N_EVENTS = 200
HOW = ("none", "some", "all")


@dataclass(slots=True)
class Cuts:
    """What came of power cuts at random moments of one run of `power_work.py`."""

    holder: str
    synchronous: str
    n_cuts: int = 0
    n_confirmed: int = 0
    lost: int = 0
    partial: int = 0
    damaged: int = 0


def can_cut() -> bool:
    """Whether the shim can be built and loaded here."""
    return sys.platform == "linux" and shutil.which("gcc") is not None


def build_shim(folder: Path) -> Path:
    """Compile `disk_log.c` into `folder`."""
    shim = folder / "disk_log.so"
    flags = ["-shared", "-fPIC", "-O1", "-o", str(shim), str(HERE / "disk_log.c"), "-ldl"]
    subprocess.run(["gcc", *flags], check=True)
    return shim


def cut_power(
    folder: Path,
    n_cuts: int,
    rng: np.random.Generator,
    *,
    holder: str,
    synchronous: str = "FULL",
    model: bool = True,
) -> Cuts:
    """Run the work once, and look at `n_cuts` disks that a cut may leave, in an empty `folder`.

    It ends with a calibration, unless `model` is false.
    """
    sources = _sources(folder / "sources")
    disk_folder = folder / "disk"
    disk_folder.mkdir()
    database = disk_folder / "avahazard.db"
    upkeep.create(str(database))
    disk = disk_of(disk_folder)
    log = folder / "log"
    last = ["calibrate"] if model else []
    subprocess.run(
        [
            sys.executable,
            str(HERE / "power_work.py"),
            str(database),
            holder,
            synchronous,
            *sources,
            *last,
        ],
        check=True,
        stdout=subprocess.PIPE,
        cwd=HERE.parents[1],
        env={
            **os.environ,
            "LD_PRELOAD": str(build_shim(folder)),
            "TRUST_LOG": str(log),
            "TRUST_FOLDER": str(disk_folder),
            "PYTHONPATH": str(HERE.parents[1]),
        },
    )
    steps = steps_of(log)
    told = list(confirmed(steps))
    found = Cuts(holder, synchronous, n_cuts)
    at = 0
    for cut in np.sort(rng.integers(len(steps), size=n_cuts)):
        while at < cut:
            disk.take(steps[at])
            at += 1
        files = disk.after_cut(HOW[int(rng.integers(len(HOW)))], rng)
        _judge(found, files, [line for k, line in told if k < cut], folder / "left")
    return found


def _judge(found: Cuts, files: dict[str, bytes], told: list[str], folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, content in files.items():
        if not name.endswith("-shm"):  # the index of the log is memory, and made anew
            (folder / Path(name).name).write_bytes(content)
    database = folder / "avahazard.db"
    found.n_confirmed += len(told)
    try:
        found.damaged += bool(check(str(database)).problems)
        with closing(sqlite3.connect(database)) as connection:
            query = "SELECT substr(event_id, 1, instr(event_id, '-') - 1), count(*) FROM events"
            events = dict(connection.execute(f"{query} GROUP BY 1").fetchall())
            models = {name for (name,) in connection.execute("SELECT name FROM models")}
    except Exception:  # whatever it is, the file cannot be read
        found.damaged += 1
        return
    found.partial += sum(n != N_EVENTS for n in events.values())
    for line in told:
        what, name = line.split()
        found.lost += name not in (models if what == "calibrated" else events)


def _sources(folder: Path) -> list[str]:
    made = []
    for k in range(4):
        file = folder / str(k) / "events.csv"
        file.parent.mkdir(parents=True)
        rows = "".join(
            f"{k}-{i},900,{1400 + (37 * i + 11 * k) % 700},{1000 + 50 * i}\n"
            for i in range(N_EVENTS)
        )
        head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
        file.write_text(head + rows, encoding="utf-8")
        made.append(str(file))
    return made
