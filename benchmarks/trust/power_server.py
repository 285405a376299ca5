"""Power cuts of a PostgreSQL server: its own files are logged, and served again after each cut."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psycopg

from avahazard.store import upkeep
from benchmarks.trust.disk_replay import disk_of
from benchmarks.trust.power import Cuts, can_cut, disks_after_cuts, judge, logs, work

USER = "postgres" if os.geteuid() == 0 else None
"""The server refuses to run as root."""
START_S = 60
# Small segments of the log and little memory: it writes, syncs and takes up files all the time.
SMALL = ("shared_buffers=1MB", "max_wal_size=4MB", "min_wal_size=2MB", "bgwriter_delay=10ms")


def programs() -> Path | None:
    """The folder of the newest server that is installed, None where there is none."""
    found = Path("/usr/lib/postgresql").glob("*/bin/initdb")
    newest = max(found, key=lambda f: float(f.parents[1].name), default=shutil.which("initdb"))
    return Path(newest).resolve().parent if newest else None


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
    with tempfile.TemporaryDirectory(prefix="trust-pg-") as name:
        cluster = Path(name)
        _own(cluster)
        data, left = cluster / "data", cluster / "left" / "data"
        words = ["-D", data, "-U", "postgres", "-A", "trust", "-E", "UTF8", "--no-sync"]
        subprocess.run(
            [programs() / "initdb", *words, "--wal-segsize=1", "--data-checksums"],
            check=True, stdout=subprocess.DEVNULL, cwd=cluster, user=USER,
        )  # fmt: skip
        with _serving(data) as database:
            upkeep.create(database)
        disk = disk_of(data)
        folders = [place for place in data.rglob("*") if place.is_dir()]
        logging = logs(cluster, data)
        _own(cluster)
        with _serving(data, *SMALL, f"synchronous_commit={synchronous}", env=logging) as database:
            work(database, folder, logging, "alone", "FULL", model=model)
        for files, told in disks_after_cuts(disk, logging, n_cuts, rng):
            shutil.rmtree(left.parent, ignore_errors=True)
            _lay(files, data, left, folders)
            try:
                with _serving(left, "fsync=off") as restored:
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
    _own(left.parent)


@contextmanager
def _serving(data: Path, *settings: str, env: Mapping[str, str] | None = None) -> Iterator[str]:
    """Serve the cluster in `data` on a socket beside it; yield the URL of its first database.

    Raises:
        RuntimeError: the server ends, or is not ready after a minute.
    """
    sockets = data.parent
    given = [word for one in ("listen_addresses=", *settings) for word in ("-c", one)]
    with (sockets / "messages").open("a") as log:
        server = subprocess.Popen(
            [programs() / "postgres", "-D", data, "-k", sockets, *given],
            stdout=log, stderr=log, cwd=sockets, user=USER, env={**os.environ, **(env or {})},
        )  # fmt: skip
    try:
        until = time.monotonic() + START_S
        while True:
            try:
                psycopg.connect(host=str(sockets), user="postgres", dbname="postgres").close()
                break
            except psycopg.OperationalError as error:
                if server.poll() is not None or time.monotonic() > until:
                    said = (sockets / "messages").read_text()
                    raise RuntimeError(f"the server does not start: {said[-2000:]}") from error
                time.sleep(0.02)
        yield f"postgresql+psycopg://postgres@/postgres?host={sockets}"
    finally:
        if server.poll() is None:
            server.send_signal(signal.SIGINT)  # a fast end, but a clean one
        server.wait()


def _own(folder: Path) -> None:
    """Give `folder` and what is in it to the user that the server runs as."""
    if USER is not None:
        owner = pwd.getpwnam(USER)
        for place in (folder, *folder.rglob("*")):
            os.chown(place, owner.pw_uid, owner.pw_gid)
