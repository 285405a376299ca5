"""Power cuts of a PostgreSQL server: its own files are logged, and served again after each cut."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from avahazard.store import upkeep
from benchmarks.trust.cluster import new_cluster, own, programs, serving
from benchmarks.trust.disk_replay import disk_of
from benchmarks.trust.power import Cuts, can_cut, disks_after_cuts, judge, logs, work

# Small segments of the log and little memory: it writes, syncs and takes up files all the time.
SMALL = ("shared_buffers=1MB", "max_wal_size=4MB", "min_wal_size=2MB", "bgwriter_delay=10ms")


def can_cut_server() -> bool:
    """Whether a server can be started here, and logged."""
    return can_cut() and programs() is not None


def cut_server_power(
    folder: Path,
    n_cuts: int,
    rng: np.random.Generator,
    *,
    synchronous: str = "on",
    model: bool = True,
) -> Cuts:
    """As `cut_power`; `synchronous` is the server's `synchronous_commit`, by default `on`."""
    found = Cuts("server", synchronous)
    with new_cluster("--wal-segsize=1", "--data-checksums") as cluster:
        data = cluster / "data"
        with serving(data) as database:
            upkeep.create(database)
        disk = disk_of(data)
        folders = [place for place in data.rglob("*") if place.is_dir()]
        logging = logs(cluster, data)
        own(cluster)
        with serving(data, *SMALL, f"synchronous_commit={synchronous}", env=logging) as database:
            work(database, folder, logging, "alone", "FULL", model=model)
        left = cluster / "left" / "data"
        for files, told in disks_after_cuts(disk, logging, n_cuts, rng):
            shutil.rmtree(left.parent, ignore_errors=True)
            _lay(files, data, left, folders)
            try:
                with serving(left, "fsync=off") as restored:
                    judge(found, restored, told)
            except RuntimeError:
                found.n_cuts += 1
                found.n_confirmed += len(told)
                found.damaged += 1
    return found


def _lay(files: dict[str, bytes], data: Path, left: Path, folders: list[Path]) -> None:
    """Write the files of the cluster in `data` to `left`, with all its `folders`."""
    for place in (data, *folders):
        (left / place.relative_to(data)).mkdir(mode=0o700, parents=True, exist_ok=True)
    for name, content in files.items():
        if not name.endswith("postmaster.pid"):  # of a process that the cut has ended
            (left / Path(name).relative_to(data)).write_bytes(content)
    own(left.parent)
