"""Power cuts: what was confirmed is there, when only what was synced has reached the disk."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sqlalchemy import text

from avahazard.store import upkeep
from avahazard.store.session import reading
from avahazard.workflow.database import check
from benchmarks.trust.disk_replay import Disk, confirmed, disk_of, steps_of

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
    disk_folder = folder / "disk"
    disk_folder.mkdir()
    database = disk_folder / "avahazard.db"
    upkeep.create(str(database))
    disk = disk_of(disk_folder)
    logging = logs(folder, disk_folder)
    work(str(database), folder, logging, holder, synchronous, model=model)
    found = Cuts(holder, synchronous)
    for files, told in disks_after_cuts(disk, logging, n_cuts, rng):
        left = folder / "left"
        shutil.rmtree(left, ignore_errors=True)
        left.mkdir()
        for name, content in files.items():
            if not name.endswith("-shm"):  # the index of the log is memory, and made anew
                (left / Path(name).name).write_bytes(content)
        judge(found, str(left / "avahazard.db"), told)
    return found


def logs(folder: Path, disk_folder: Path) -> dict[str, str]:
    """What in its environment lets a process log to `folder` what it asks of `disk_folder`."""
    return {
        "LD_PRELOAD": str(build_shim(folder)),
        "TRUST_LOG": str(folder / "log"),
        "TRUST_FOLDER": str(disk_folder),
    }


def work(
    database: str, folder: Path, logging: dict[str, str], *how: str, model: bool = True
) -> None:
    """Do the work of `power_work.py`, logged; its files are written to `folder`."""
    last = ["calibrate"] if model else []
    words = [str(HERE / "power_work.py"), database, *how, *_sources(folder / "sources"), *last]
    subprocess.run(
        [sys.executable, *words],
        check=True,
        stdout=subprocess.PIPE,
        cwd=HERE.parents[1],
        env={**os.environ, **logging, "PYTHONPATH": str(HERE.parents[1])},
    )


def disks_after_cuts(
    disk: Disk, logging: dict[str, str], n_cuts: int, rng: np.random.Generator
) -> Iterator[tuple[dict[str, bytes], list[str]]]:
    """The files that each of `n_cuts` may leave, and the lines that had confirmed something."""
    steps = steps_of(Path(logging["TRUST_LOG"]))
    told = list(confirmed(steps))
    at = 0
    for cut in np.sort(rng.integers(len(steps), size=n_cuts)):
        while at < cut:
            disk.take(steps[at])
            at += 1
        files = disk.after_cut(HOW[int(rng.integers(len(HOW)))], rng)
        yield files, [line for k, line in told if k < cut]


def judge(found: Cuts, database: str, told: list[str]) -> None:
    """Count what is lost, in part or damaged in a database after a cut."""
    found.n_cuts += 1
    found.n_confirmed += len(told)
    try:
        damaged = bool(check(database).problems)
        with reading(database) as session:
            ids = session.scalars(text("SELECT event_id FROM events")).all()
            models = set(session.scalars(text("SELECT name FROM models")).all())
        events = Counter(name.split("-")[0] for name in ids)
    except Exception:  # whatever it is, the database cannot be read
        found.damaged += 1
        return
    found.damaged += damaged
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
