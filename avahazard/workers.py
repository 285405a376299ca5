"""The threads that share the work of this process: kernels leave Python's lock.

There is one pool, made when first used. All work is done in it: a worker that shares out its own
does it as well, and those that are idle help.
"""

import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")

SWITCH_S = 5e-4
"""How long a thread keeps Python's lock where another waits for it."""

_inside = threading.local()
_chosen: int | None = None
_pool: ThreadPoolExecutor | None = None


def set_workers(n: int | None) -> None:
    """Let `n` threads share the work; None: as many as the process may use cores."""
    global _chosen, _pool
    if _pool is not None:
        _pool.shutdown(wait=False)
    _chosen, _pool = n, None


def n_workers() -> int:
    """How many calls of `ordered_map` run side by side from here, at most."""
    return 1 if getattr(_inside, "alone", False) else _chosen or _cores()


def inside_worker() -> bool:
    """Whether this is the work of a worker."""
    return getattr(_inside, "worker", False)


@contextmanager
def one_worker() -> Iterator[None]:
    """Let what runs inside do its own parts by itself, as the worker of another process."""
    before = vars(_inside).copy()
    _inside.worker = _inside.alone = True
    try:
        yield
    finally:
        vars(_inside).clear()
        vars(_inside).update(before)


def ordered_map(function: Callable[..., T], *items: Iterable[Any]) -> Iterator[T]:
    """As `map`, by the workers that are idle; each result comes as soon as those before it.

    Inside a worker they come when all are there. `function` must not care for who else runs, so
    that any number of workers gives the same.
    """
    if n_workers() < 2:
        return map(function, *items)
    if not inside_worker():
        return pool().map(function, *items)
    given = list(zip(*items, strict=False))
    found: dict[int, T] = {}
    left = iter(range(len(given)))

    def work() -> None:
        for k in left:
            found[k] = function(*given[k])

    helpers = [pool().submit(work) for _ in range(min(n_workers(), len(given)) - 1)]
    work()
    for helper in helpers:
        if not helper.cancel():
            helper.result()
    return (found[k] for k in range(len(given)))


def pool() -> ThreadPoolExecutor:
    """The threads."""
    global _pool  # noqa: PLW0603
    if _pool is None:
        # A kernel takes some 100 µs; each would wait up to 5 ms for Python's lock.
        sys.setswitchinterval(SWITCH_S)
        mark = setattr, (_inside, "worker", True)
        _pool = ThreadPoolExecutor(_chosen or _cores(), "avahazard", *mark)
    return _pool


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _forget() -> None:
    """A forked process has none of its parent's threads."""
    global _pool  # noqa: PLW0603
    _pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
