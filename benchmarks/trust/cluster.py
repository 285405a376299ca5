"""A PostgreSQL server of one's own: on a socket in a temporary folder, with no port."""

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

import psycopg

USER = "postgres"
START_S = 60


def programs() -> Path | None:
    """The folder of the newest server that is installed, None where there is none."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=_version)
    here = shutil.which("initdb")
    return found[-1].parent if found else Path(here).resolve().parent if here else None


@contextmanager
def new_cluster(*options: str) -> Iterator[Path]:
    """A folder with a new cluster in its folder `data`; both are removed at the end."""
    folder = Path(tempfile.mkdtemp(prefix="trust-pg-"))
    try:
        own(folder)
        made = [str(_program("initdb")), "-D", str(folder / "data"), "-U", USER, "-A", "trust"]
        subprocess.run(
            [*made, "-E", "UTF8", "--no-sync", *options],
            check=True, stdout=subprocess.DEVNULL, cwd=folder, user=_user(),
        )  # fmt: skip
        yield folder
    finally:
        shutil.rmtree(folder)


@contextmanager
def serving(data: Path, *settings: str, env: Mapping[str, str] | None = None) -> Iterator[str]:
    """Serve the cluster in `data`; yield the URL of its database `postgres`.

    Raises:
        RuntimeError: the server ends, or is not ready after a minute.
    """
    sockets = data.parent
    given = [word for one in ("listen_addresses=", *settings) for word in ("-c", one)]
    with (data.parent / "messages").open("a") as log:
        server = subprocess.Popen(
            [_program("postgres"), "-D", data, "-k", sockets, *given],
            stdout=log, stderr=log, cwd=sockets, user=_user(), env={**os.environ, **(env or {})},
        )  # fmt: skip
    try:
        _await(server, sockets)
        yield f"postgresql+psycopg://{USER}@/postgres?host={sockets}"
    finally:
        if server.poll() is None:
            server.send_signal(signal.SIGINT)  # a fast end, but a clean one
        server.wait()


def own(folder: Path) -> None:
    """Give `folder` and what is in it to the user that the server runs as."""
    if (user := _user()) is not None:
        owner = pwd.getpwnam(user)
        for place in (folder, *folder.rglob("*")):
            os.chown(place, owner.pw_uid, owner.pw_gid)


def _await(server: subprocess.Popen[bytes], sockets: Path) -> None:
    until = time.monotonic() + START_S
    while server.poll() is None and time.monotonic() < until:
        try:
            psycopg.connect(host=str(sockets), user=USER, dbname="postgres").close()
        except psycopg.OperationalError:
            time.sleep(0.02)
        else:
            return
    said = (sockets / "messages").read_text()
    raise RuntimeError(f"the server does not start: {said[-2000:]}")


def _program(name: str) -> Path:
    folder = programs()
    if folder is None:
        raise RuntimeError("no PostgreSQL server is installed")
    return folder / name


def _user() -> str | None:
    """The server refuses to run as root."""
    return USER if os.geteuid() == 0 else None


def _version(initdb: Path) -> float:
    return float(initdb.parents[1].name)
