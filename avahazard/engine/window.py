"""Work under way, by whoever does it: a bounded number of items, taken in their order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

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
