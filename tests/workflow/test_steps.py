"""One progress for work of several steps."""

from __future__ import annotations

import pytest

from avahazard.workflow.steps import steps


def test_the_whole_goes_up_once() -> None:
    told: list[tuple[str, float]] = []
    first, second, third = steps(
        lambda what, done, total: told.append((what, done / total)), (2, 1, 1)
    )
    inner = steps(second, (1, 3))
    for tell, what, done, total in (
        (first, "a", 0.0, 7.0),
        (first, "a", 7.0, 7.0),
        (inner[0], "b", 1.0, 1.0),
        (inner[1], "c", 5.0, 1.0),  # more than all of it is all of it
        (third, "d", 0.0, 0.0),  # of nothing nothing is done
        (third, "d", 1.0, 1.0),
    ):
        tell(what, done, total)
    assert [share for _, share in told] == pytest.approx([0.0, 0.5, 0.5625, 0.75, 0.75, 1.0])
    assert "".join(what for what, _ in told) == "aabcdd"
