"""Who does the work: threads of this process, processes of this machine, or a dask cluster."""

from __future__ import annotations

import logging
import tempfile
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from avahazard.records.errors import AvahazardError
from avahazard.workers import inside_worker, n_workers, one_worker, pool, set_workers

if TYPE_CHECKING:
    from distributed import Client

EngineName = Literal["local", "processes", "dask"]
LOCAL: EngineName = "local"
Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Choice:
    """An engine: threads here, processes here, or dask; `scheduler` is the address of its own.

    `tell` is called with what a person should know, such as where dask's dashboard is.
    """

    name: EngineName = LOCAL
    scheduler: str | None = None
    tell: Tell = lambda _words: None


_chosen = Choice()


def set_engine(
    name: EngineName = LOCAL,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell = lambda _words: None,
) -> None:
    """Let this engine do the work from now on, with so many workers (None: the cores).

    `scheduler` is the address of a dask scheduler; dask without one has its own on this machine.
    Raises `AvahazardError` for a scheduler of another engine, and where dask is not installed.
    """
    global _chosen  # noqa: PLW0603
    if scheduler is not None and name != "dask":
        raise AvahazardError(
            f"The engine {name} has no scheduler.", "Give --engine dask with --scheduler."
        )
    close_engine()
    if name == "dask" and find_spec("distributed") is None:
        raise AvahazardError(
            "The engine dask needs the package distributed, which is not installed.",
            "Install it: pip install 'avahazard[cluster]'; or take --engine processes.",
        )
    set_workers(workers)
    _chosen = Choice(name, scheduler, tell)


def chosen() -> Choice:
    """The engine that does the work."""
    return _chosen


def close_engine() -> None:
    """End what the engine has started; it goes back to threads."""
    global _chosen, _client
    before, _chosen = _chosen, Choice()
    client, _client = _client, None
    if before.name == "processes":
        from loky import get_reusable_executor  # noqa: PLC0415 (slow)

        get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)
    if client is not None:
        cluster = client.cluster
        client.close()
        if cluster is not None:
            cluster.close()


Item = TypeVar("Item")
Out = TypeVar("Out")

AHEAD = 4
"""Items under way for each worker: none waits for work, and few results wait to be taken."""
MAX_DEATHS = 4
"""Times that processes may die on one item before it is given up."""


def in_order(
    items: Iterable[Item],
    ahead: int,
    submit: Callable[[Item], Future[Out]],
    death: type[Exception] | tuple[()] = (),
) -> Iterator[Out]:
    """What comes of every item, in the order of the items, `ahead` of them under way at most.

    `submit` begins the work on one; what has not begun is given up when nobody asks any more, or
    when an item has raised. Where a worker's `death` is raised, all that was under way is done
    again. Raises `AvahazardError` where workers die again and again.
    """
    waiting: deque[tuple[Item, Future[Out]]] = deque()

    def take() -> Out:
        for _ in range(MAX_DEATHS):
            try:
                found = waiting[0][1].result()
            except death:
                again = [(item, submit(item)) for item, _ in waiting]
                waiting.clear()
                waiting.extend(again)
            else:
                waiting.popleft()
                return found
        raise AvahazardError(
            f"Worker processes were ended {MAX_DEATHS} times on the same work.",
            "Most often memory is short: give fewer --workers.",
        )

    try:
        for item in items:
            waiting.append((item, submit(item)))
            if len(waiting) >= ahead:
                yield take()
        while waiting:
            yield take()
    finally:
        for _, future in waiting:
            future.cancel()


Shared = TypeVar("Shared")


def spread_map(
    function: Callable[[Shared, Item], Out],
    shared: Shared,
    items: Iterable[Item],
    *,
    threads: bool = True,
) -> Iterator[Out]:
    """`function(shared, item)` of every item, in the order of the items, as they are ready.

    `shared` goes to each worker once, an item with each call; both are pickled, so keep items
    small. Few results are held. They must hang on `shared` and the item alone (seeds keyed by what
    is computed): a call whose worker dies is made again. `threads` is False where `shared` must not
    be used by two threads at once; threads then do one item after the other.
    """
    if inside_worker():
        return map(partial(function, shared), items)
    engine = chosen()
    if engine.name == "processes":
        return map_processes(function, shared, items, n_workers())
    if engine.name == "dask":
        return map_dask(function, shared, items, engine, n_workers())
    if not threads or n_workers() == 1:
        return map(partial(function, shared), items)
    submit = partial(pool().submit, partial(function, shared))
    return in_order(items, AHEAD * n_workers(), submit)


def pack(function: Callable[[Any, Any], Any], shared: object) -> bytes:
    """The two as bytes; cloudpickle takes functions inside functions, which effects are made of."""
    import cloudpickle  # noqa: PLC0415 (slow)

    return bytes(cloudpickle.dumps((function, shared)))


@lru_cache(maxsize=1)
def _unpacked(data: bytes | Path) -> Any:
    """What was packed, of which a worker keeps the last."""
    import cloudpickle  # noqa: PLC0415 (slow)

    return cloudpickle.loads(data if isinstance(data, bytes) else data.read_bytes())


def call_packed(data: bytes | Path, item: object) -> Any:
    """Call the function on an item in a worker; `data` are the bytes, or the file with them."""
    function, shared = _unpacked(data)
    with one_worker():
        return function(shared, item)


IDLE_S = 600
"""Idle processes end after this time."""


def map_processes(
    function: Callable[[Any, Any], Any], shared: object, items: Iterable[Any], n: int
) -> Iterator[Any]:
    """`spread_map` by `n` processes. What is shared reaches them through a file.

    Raises `AvahazardError` where processes die again and again.
    """
    from loky import get_reusable_executor  # noqa: PLC0415 (slow)
    from loky.process_executor import BrokenProcessPool  # noqa: PLC0415

    with tempfile.TemporaryDirectory(prefix="avahazard-") as folder:
        file = Path(folder) / "shared"
        file.write_bytes(pack(function, shared))

        def submit(item: object) -> Any:
            # One death breaks the whole pool: another one is made then.
            executor = get_reusable_executor(max_workers=n, timeout=IDLE_S)
            return executor.submit(call_packed, file, item)

        yield from in_order(items, AHEAD * n, submit, BrokenProcessPool)


TIMEOUT_S = 30
"""How long a scheduler, and its first worker, may take to answer."""

_client: Client | None = None


def map_dask(
    function: Callable[[Any, Any], Any],
    shared: object,
    items: Iterable[Any],
    choice: Choice,
    n: int,
) -> Iterator[Any]:
    """`spread_map` by the workers of a cluster; an own one has `n`.

    What is shared is a task of its own, so that dask makes it again when the workers that held
    it have died. Raises `AvahazardError` where no scheduler or worker answers, or workers die
    again and again.
    """
    from distributed import KilledWorker  # noqa: PLC0415 (may be missing)
    from distributed.client import FutureCancelledError  # noqa: PLC0415

    client = _connected(choice, n)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Sending large graph")  # it is sent once
        held = client.submit(bytes, pack(function, shared))
    ahead = AHEAD * max(sum(client.nthreads().values()), n)

    def submit(item: object) -> Any:
        return client.submit(call_packed, held, item, pure=False)

    try:
        yield from in_order(items, ahead, submit)
    except KilledWorker as error:
        raise AvahazardError(
            f"Workers of the cluster died again and again on the same work: {error}",
            "Most often memory is short: give a worker more, or fewer threads.",
        ) from error
    except FutureCancelledError as error:
        raise AvahazardError(
            f"The scheduler {client.scheduler.address if client.scheduler else ''} is gone.",
            "Start it again, and the command too: it goes on where it can.",
        ) from error


def _connected(choice: Choice, n: int) -> Client:
    global _client  # noqa: PLW0603
    if _client is None:
        _client = _own_cluster(n) if choice.scheduler is None else _of_scheduler(choice.scheduler)
        choice.tell(f"dask: {len(_client.nthreads())} workers, dashboard {_client.dashboard_link}")
    return _client


def _own_cluster(n: int) -> Client:
    import dask  # noqa: PLC0415 (may be missing)
    from distributed import Client, LocalCluster  # noqa: PLC0415

    # Workers complain of lost connections when they are ended.
    dask.config.set({"distributed.logging": {"distributed": "critical"}})
    cluster = LocalCluster(
        n_workers=n,
        threads_per_worker=1,
        # Any free port: the usual one is taken where two run side by side.
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
    )
    return Client(cluster)


def _of_scheduler(address: str) -> Client:
    from distributed import Client  # noqa: PLC0415 (may be missing)

    try:
        client = Client(address, timeout=TIMEOUT_S)
    except (OSError, ValueError) as error:
        raise AvahazardError(
            f"No dask scheduler answers at {address}.",
            "Start one with `dask scheduler`, and workers with `dask worker ADDRESS`.",
        ) from error
    try:
        client.wait_for_workers(1, timeout=TIMEOUT_S)
        # Other versions would give other bits, or none.
        here, there = version("avahazard"), client.run(version, "avahazard", on_error="return")
        others = sorted(set(map(str, there.values())) - {here})
    except TimeoutError as error:
        client.close()
        raise AvahazardError(
            f"The scheduler {address} has no workers.", f"Start some: dask worker {address}"
        ) from error
    if others:
        client.close()
        raise AvahazardError(
            f"Workers of {address} do not have avahazard {here} as here: {', '.join(others)}.",
            "Install the same version, with its lock, on all.",
        )
    return client
