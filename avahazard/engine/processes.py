"""Processes of this machine, by loky: each does one item at a time."""

from __future__ import annotations

import hashlib
import tempfile
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import cloudpickle
from loky import get_reusable_executor
from loky.process_executor import BrokenProcessPool

from avahazard.engine import AHEAD, in_order
from avahazard.records.errors import AvahazardError
from avahazard.workers import one_worker

_kept: dict[str, tuple[Callable[[Any, Any], Any], Any]] = {}
"""The last that was unpickled in this worker."""


def pack(function: Callable[[Any, Any], Any], shared: object) -> tuple[str, bytes]:
    """A name for the two, by what they hold, and their bytes.

    cloudpickle takes functions inside functions too, which effects are made of.
    """
    data: bytes = cloudpickle.dumps((function, shared))
    return hashlib.sha256(data).hexdigest(), data


def call_packed(name: str, data: bytes | Path, item: object) -> Any:
    """Call the function on an item in a worker; `data` are the bytes, or the file with them."""
    found = _kept.get(name)
    if found is None:
        content = data if isinstance(data, bytes) else data.read_bytes()
        found = cloudpickle.loads(content)
        _kept.clear()
        _kept[name] = found
    function, shared = found
    with one_worker():
        return function(shared, item)


Waiting = deque[tuple[object, Future[Any]]]

MAX_DEATHS = 4
"""Times that processes may die on one item before it is given up."""
IDLE_S = 600
"""Idle processes end after this time."""


def map_processes(
    function: Callable[[Any, Any], Any], shared: object, items: Iterable[Any], n: int
) -> Iterator[Any]:
    """`spread_map` by `n` processes. What is shared reaches them through a file.

    Raises `AvahazardError` where processes die again and again.
    """
    name, data = pack(function, shared)
    with tempfile.TemporaryDirectory(prefix="avahazard-") as folder:
        file = Path(folder) / "shared"
        file.write_bytes(data)
        del data

        def begin(item: object) -> tuple[object, Future[Any]]:
            pool = get_reusable_executor(max_workers=n, timeout=IDLE_S)
            return item, pool.submit(call_packed, name, file, item)

        def first(waiting: Waiting) -> Any:
            for _ in range(MAX_DEATHS):
                try:
                    return waiting[0][1].result()
                except BrokenProcessPool:
                    # One death breaks the whole pool: all that was under way is done again.
                    again = [begin(item) for item, _ in waiting]
                    waiting.clear()
                    waiting.extend(again)
            raise AvahazardError(
                f"Worker processes were ended {MAX_DEATHS} times on the same work.",
                "Most often memory is short: give fewer --workers.",
            )

        yield from in_order(items, AHEAD * n, begin, first, _cancel)


def _cancel(waiting: Waiting) -> None:
    for _, future in waiting:
        future.cancel()


def close() -> None:
    """End the processes."""
    get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)
