"""What is kept of what was made before, within a bound of memory."""

from __future__ import annotations

MOST_BYTES, LEAST_KEPT = 64_000_000, 2
"""Memory of what is kept of one kind, and how many are kept whatever they take."""


def within(most: int, size: int) -> int:
    """How many things of `size` bytes are kept: at most `most`, fewer where they are large."""
    return max(LEAST_KEPT, min(most, MOST_BYTES // max(size, 1)))


def make_room(kept: dict, most: int) -> None:  # type: ignore[type-arg]
    """Drop the oldest of what is kept, so that one more stays within `most`."""
    while len(kept) >= most:
        del kept[next(iter(kept))]
