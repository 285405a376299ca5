"""What is kept within a bound of memory."""

from __future__ import annotations

import pytest

from avahazard.inference.likelihood.keeping import make_room, within


@pytest.mark.parametrize(
    ("size", "kept"), [(0, 64), (1_000_000, 64), (2_000_000, 32), (40_000_000, 2), (10**12, 2)]
)
def test_fewer_are_kept_where_they_are_large(size: int, kept: int) -> None:
    assert within(64, size) == kept


def test_the_oldest_goes_first() -> None:
    kept = dict.fromkeys("abcd", 0)
    make_room(kept, 3)
    assert list(kept) == ["c", "d"]
    make_room(kept, 3)
    assert list(kept) == ["c", "d"]
