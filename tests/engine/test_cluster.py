"""dask: a cluster of its own, and one of separate processes of which one is killed."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from avahazard.engine import set_engine, spread_map
from avahazard.records.errors import AvahazardError
from tests.engine import work

pytestmark = pytest.mark.usefixtures("default_engine")

N = 24
ROOT = Path(__file__).resolve().parents[2]


def test_an_own_cluster_gives_the_same_bits() -> None:
    told: list[str] = []
    set_engine("dask", workers=2, tell=told.append)
    found = np.array(list(spread_map(work.draws, 3, range(N))))
    assert found.tobytes() == np.array([work.draws(3, item) for item in range(N)]).tobytes()
    assert told[0].startswith("dask: 2 workers, dashboard http://127.0.0.1:")
    assert {n for _, n in spread_map(work.inside, None, range(4))} == {1}
    with pytest.raises(ZeroDivisionError):
        list(spread_map(work.discontinuous, None, range(8)))


@pytest.fixture
def scheduler() -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and two workers, each a process of its own, on loopback."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    port = address.rsplit(":", 1)[1]
    started = [_dask("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")]
    started += [
        _dask("worker", address, "--no-nanny", "--no-dashboard", "--nthreads", "1")
        for _ in range(2)
    ]
    yield address, started
    for process in reversed(started):
        process.kill()
        process.wait()


def _dask(*words: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "dask", *words]
    return subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)


@pytest.mark.slow
def test_a_worker_of_another_cluster_may_die(
    scheduler: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    address, started = scheduler
    set_engine("dask", scheduler=address)
    assert len({process for process, _ in spread_map(work.inside, None, range(16))}) == 2
    found = list(spread_map(work.draws_or_death, (3, tmp_path), range(N)))
    assert np.array(found).tobytes() == np.array([work.draws(3, k) for k in range(N)]).tobytes()
    assert [process.poll() is None for process in started].count(False) == 1


def test_a_scheduler_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("avahazard.engine.TIMEOUT_S", 0.3)
    set_engine("dask", scheduler="tcp://127.0.0.1:9")
    with pytest.raises(AvahazardError, match="No dask scheduler answers"):
        list(spread_map(work.draws, 3, range(2)))


def test_dask_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("avahazard.engine.find_spec", lambda _name: None)
    with pytest.raises(AvahazardError, match="not installed") as refused:
        set_engine("dask")
    assert "avahazard[cluster]" in refused.value.hint
