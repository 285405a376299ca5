"""Power cuts: what was confirmed is there, when only what was synced has reached the disk.

Run as a program it is the work that a cut ends, imports and then a calibration. Its words: the
database, `alone` or `held` (another connection keeps the log open), what `synchronous` is to be
(FULL is the program's own, any other shows that the study sees losses), files to import, and
`calibrate`.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import event, text
from sqlalchemy.engine import Engine

from avahazard.store import upkeep
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import check, import_files
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.study import Line, table
from benchmarks.trust.disk_replay import Disk, confirmed, disk_of, steps_of

HERE = Path(__file__).resolve().parent
N_EVENTS = 200
HOW = ("none", "some", "all")
HEAD = "event_id,fall_height_m,runout_length_m,volume_m3\n"


@dataclass(slots=True)
class Cuts:
    """What came of power cuts at random moments of one run of the work."""

    holder: str
    synchronous: str
    n_cuts: int = 0
    n_confirmed: int = 0
    lost: int = 0
    partial: int = 0
    damaged: int = 0


def power(given: Any, folder: Path) -> Line:
    """Power cuts; with weaker syncs too, which shows that the study sees losses."""
    if not can_cut():
        raise SystemExit("power: no gcc here to build what logs the writes.")
    rows = []
    ways = (("alone", "FULL"), ("held", "FULL"), ("held", "NORMAL"), ("alone", "OFF"))
    for k, (holder, synchronous) in enumerate(ways):
        inside = folder / str(k)
        inside.mkdir()
        rng = np.random.default_rng([given.seed, k])
        n = given.cuts if synchronous == "FULL" else min(given.cuts, 100)
        found = cut_power(inside, n, rng, holder=holder, synchronous=synchronous)
        rows.append(asdict(found))
        print(rows[-1])
    return {"rows": rows}


def page(found: Line) -> str:
    """A row for each way to sync."""
    names = {"alone": "SQLite, {}", "held": "SQLite, {}, log held open"}
    counts = ("n_cuts", "n_confirmed", "lost", "partial", "damaged")
    rows = [
        (names[row["holder"]].format(row["synchronous"]), *(row[n] for n in counts))
        for row in found["rows"]
    ]
    return table(("sync", "cuts", "confirmed", "lost", "in part", "damaged"), rows)


def can_cut() -> bool:
    """Whether the shim can be built and loaded here."""
    return sys.platform == "linux" and shutil.which("gcc") is not None


def build(source: Path, folder: Path) -> Path:
    """The shared library of a C file, compiled into `folder`."""
    shim = folder / source.with_suffix(".so").name
    if not shim.exists():
        flags = ["-shared", "-fPIC", "-O1", "-o", str(shim), str(source), "-ldl"]
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
    log = folder / "log"
    shim = str(build(HERE / "disk_log.c", folder))
    logging = {"LD_PRELOAD": shim, "TRUST_LOG": str(log), "TRUST_FOLDER": str(disk_folder)}
    _work(str(database), folder, logging, holder, synchronous, model=model)
    found, left = Cuts(holder, synchronous), folder / "left"
    for files, told in disks_after_cuts(disk, log, n_cuts, rng):
        shutil.rmtree(left, ignore_errors=True)
        left.mkdir()
        for name, content in files.items():
            if not name.endswith("-shm"):  # the index of the log is memory, and made anew
                (left / Path(name).name).write_bytes(content)
        _judge(found, str(left / "avahazard.db"), told)
    return found


def _work(
    database: str, folder: Path, logging: dict[str, str], *how: str, model: bool = True
) -> None:
    """Do the work in a process that is logged; its files are written to `folder`."""
    sources = []
    for k in range(4):
        sources.append(folder / "sources" / str(k) / "events.csv")
        sources[-1].parent.mkdir(parents=True)
        rows = (
            f"{k}-{i},900,{1400 + (37 * i + 11 * k) % 700},{1000 + 50 * i}\n"
            for i in range(N_EVENTS)
        )
        sources[-1].write_text(HEAD + "".join(rows), encoding="utf-8")
    words = [database, *how, *map(str, sources), *(["calibrate"] if model else [])]
    subprocess.run(
        [sys.executable, "-m", "benchmarks.trust.power", *words],
        check=True,
        stdout=subprocess.PIPE,
        cwd=HERE.parents[1],
        env={**os.environ, **logging},
    )


def disks_after_cuts(
    disk: Disk, log: Path, n_cuts: int, rng: np.random.Generator
) -> Iterator[tuple[dict[str, bytes], list[str]]]:
    """The files that each of `n_cuts` may leave, and the lines that had confirmed something."""
    steps = steps_of(log)
    told = list(confirmed(steps))
    at = 0
    for cut in np.sort(rng.integers(len(steps), size=n_cuts)):
        while at < cut:
            disk.take(steps[at])
            at += 1
        files = disk.after_cut(HOW[int(rng.integers(len(HOW)))], rng)
        yield files, [line for k, line in told if k < cut]


def _judge(found: Cuts, database: str, told: list[str]) -> None:
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


def main() -> None:
    """Do the work, and print a line when a part is confirmed."""
    database, holder, synchronous, *files = sys.argv[1:]
    if synchronous != "FULL":
        weaker = f"PRAGMA synchronous = {synchronous}"
        event.listen(Engine, "begin", lambda c: c.exec_driver_sql(weaker), insert=True)
    other = sqlite3.connect(database) if holder == "held" else None
    if other is not None:
        other.execute("SELECT count(*) FROM events").fetchone()
    for file in files:
        if file == "calibrate":
            calibrate(database, "model", CalibrateRequest(law="power", chains=2, draws=50))
            print("calibrated model", flush=True)
        else:
            import_files(database, [Path(file)])
            print(f"imported {Path(file).parent.name}", flush=True)


if __name__ == "__main__":
    main()
