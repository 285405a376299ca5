"""The work on one path of a region: what it takes, what comes of it, and why it may fail."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, NamedTuple, TypeVar

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.fingerprint import Fingerprint
from avahazard.records.plain import plain
from avahazard.store.results import PathResult, RunKind
from avahazard.workflow.stored.region_fit import RegionFit

Shared = TypeVar("Shared")

FAILURES = (ArithmeticError, ValueError, LookupError)
"""What ends the work on one path only, besides `AvahazardError`."""


@dataclass(frozen=True, slots=True, eq=False)
class PathTask:
    """A path as one unit of work: its own records only, and their digest when the work began."""

    position: int
    path_id: str
    records: Records
    digest: bytes


@dataclass(frozen=True, slots=True, eq=False)
class PathAnswer:
    """The documents of a path, and notes for people that are in none of them."""

    documents: Sequence[object]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PathWork(Generic[Shared]):
    """What is done on every path, by `function(shared, task)`.

    `settings` are all that the result hangs on besides the model and the records.
    """

    kind: RunKind
    what: str
    function: Callable[[Shared, PathTask], PathAnswer]
    shared: Shared
    settings: Mapping[str, Any]


class PathShared(NamedTuple):
    """What all paths share: `function`, what it takes, and events for a path without any."""

    function: Callable[[Any, PathTask], PathAnswer]
    shared: object
    others: tuple[Event, ...]

    @classmethod
    def of(cls, stored: RegionFit, work: PathWork[Any]) -> PathShared:
        """Of the work with a stored model."""
        return cls(work.function, work.shared, stored.others)


def path_answer(work: PathShared, task: PathTask) -> PathResult:
    """The result of a path, or why it failed.

    Raises `AvahazardError` where somebody has changed its records since the work began.
    """
    own = task.records
    # Here, where many do it, and not by who gives out the work.
    if Fingerprint().add(own) != task.digest:
        raise AvahazardError(
            f"The records of path {task.path_id} have been changed since this began.",
            "Give the same command again: it takes the records as they are now.",
        )
    task = replace(task, records=replace(own, events=own.events or work.others))
    try:
        found = work.function(work.shared, task)
    except AvahazardError as error:
        return PathResult(task.position, task.path_id, failed=error.message, hint=error.hint)
    except FAILURES as error:
        reason = f"{type(error).__name__} on path {task.path_id}: {error}"
        return PathResult(task.position, task.path_id, failed=reason)
    documents = tuple(plain(document) for document in found.documents)
    return PathResult(task.position, task.path_id, documents, found.notes)
