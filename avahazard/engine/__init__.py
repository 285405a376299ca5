"""Who does the work: threads of this process, processes of this machine, or a dask cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeVar, get_args

from avahazard.records.errors import AvahazardError
from avahazard.workers import inside_worker, n_workers, pool, set_workers

EngineName = Literal["local", "processes", "dask"]
LOCAL: EngineName = "local"
ENGINES: tuple[EngineName, ...] = get_args(EngineName)
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
    if name == "dask":
        from avahazard.engine.cluster import require_dask  # noqa: PLC0415 (may be missing)

        require_dask()
    set_workers(workers)
    _chosen = Choice(name, scheduler, tell)


def chosen() -> Choice:
    """The engine that does the work."""
    return _chosen


def close_engine() -> None:
    """End the processes that the engine has started; it goes back to threads."""
    global _chosen
    before, _chosen = _chosen, Choice()
    if before.name == "processes":
        from avahazard.engine.processes import close  # noqa: PLC0415

        close()
    elif before.name == "dask":
        from avahazard.engine.cluster import disconnect  # noqa: PLC0415

        disconnect()


Item = TypeVar("Item")
Work = TypeVar("Work")
Out = TypeVar("Out")

AHEAD = 4
"""Items under way for each worker: none waits for work, and few results wait to be taken."""


def in_order(
    items: Iterable[Item],
    ahead: int,
    submit: Callable[[Item], Work],
    first: Callable[[deque[Work]], Out],
    cancel: Callable[[deque[Work]], object],
) -> Iterator[Out]:
    """What comes of every item, in the order of the items, `ahead` of them under way at most.

    `submit` begins the work on one, `first` waits for the oldest of those under way, `cancel`
    gives up what still is when nobody asks any more, or when `first` has raised.
    """
    waiting: deque[Work] = deque()

    def take() -> Out:
        found = first(waiting)
        waiting.popleft()
        return found

    try:
        for item in items:
            waiting.append(submit(item))
            if len(waiting) >= ahead:
                yield take()
        while waiting:
            yield take()
    finally:
        cancel(waiting)


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
    small. Items are taken as the work goes on, and few results are held. The result must hang on
    `shared` and the item alone (seeds keyed by what is computed): a call whose worker dies is made
    again. `threads` is False where `shared` must not be used by two threads at once; the threads
    of this process then do one item after the other.
    """
    if inside_worker():
        return map(partial(function, shared), items)
    engine = chosen()
    if engine.name == "processes":
        from avahazard.engine.processes import map_processes  # noqa: PLC0415 (not always there)

        return map_processes(function, shared, items, n_workers())
    if engine.name == "dask":
        from avahazard.engine.cluster import map_dask  # noqa: PLC0415 (may be missing)

        return map_dask(function, shared, items, engine, n_workers())
    if not threads or n_workers() == 1:
        return map(partial(function, shared), items)
    threads_here, call = pool(), partial(function, shared)

    def submit(item: Item) -> Future[Out]:
        return threads_here.submit(call, item)

    return in_order(items, AHEAD * n_workers(), submit, lambda w: w[0].result(), cancel_all)


def cancel_all(waiting: Iterable[Future[Out]]) -> None:
    """Give up what has not begun."""
    for future in waiting:
        future.cancel()
