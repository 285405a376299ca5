"""The engine that is chosen, and what tells of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from avahazard.records.errors import AvahazardError
from avahazard.workers import set_workers

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
