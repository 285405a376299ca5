"""The threads that share the work of this process: kernels leave Python's lock.

There is one pool. It is made when first used, and what runs in it does its own parts by itself, so
that there are never more threads at work than workers.
"""

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")

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
    """How many calls of `ordered_map` run side by side from here: one inside a worker."""
    return 1 if inside_worker() else _chosen or _cores()


def inside_worker() -> bool:
    """Whether this is the work of a worker, which does its own parts by itself."""
    return getattr(_inside, "worker", False)


@contextmanager
def one_worker() -> Iterator[None]:
    """Let what runs inside do its own parts by itself, as the worker of another process."""
    before = inside_worker()
    _inside.worker = True
    try:
        yield
    finally:
        _inside.worker = before


def ordered_map(function: Callable[..., T], *items: Iterable[Any]) -> Iterator[T]:
    """As `map`, by the workers; results come in the order of the items.

    `function` must not care for who else runs, so that any number of workers gives the same.
    """
    if n_workers() == 1:
        return map(function, *items)
    return pool().map(function, *items)


def pool() -> ThreadPoolExecutor:
    """The threads."""
    global _pool  # noqa: PLW0603
    if _pool is None:
        _pool = ThreadPoolExecutor(n_workers(), "avahazard", _mark)
    return _pool


def _mark() -> None:
    _inside.worker = True


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
