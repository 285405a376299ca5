"""One function over many items, by the engine that is chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from functools import partial
from typing import TypeVar

from avahazard.engine.choice import chosen
from avahazard.engine.window import AHEAD, in_order
from avahazard.workers import inside_worker, n_workers, pool

Shared = TypeVar("Shared")
Item = TypeVar("Item")
Out = TypeVar("Out")


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
