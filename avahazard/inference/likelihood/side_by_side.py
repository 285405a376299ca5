"""Log likelihoods at many coordinates, shared by the threads where that is worth their while."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from avahazard.workers import ordered_map

T = TypeVar("T")

WORTH_SHARING = 5000
"""Numbers (events times their volumes) of one call from which on it goes to another thread."""


def side_by_side(function: Callable[..., T], *items: Iterable[Any], n_numbers: int) -> Iterator[T]:
    """As `map`, by the threads where each call goes through many numbers."""
    if n_numbers < WORTH_SHARING:
        return map(function, *items)
    return ordered_map(function, *items)
