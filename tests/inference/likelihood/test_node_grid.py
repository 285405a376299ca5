from __future__ import annotations

from avahazard.inference.likelihood.node_grid import LEAST_KEPT, MOST_BYTES, within


def test_large_tables_are_kept_in_smaller_number() -> None:
    assert within(16, 1000) == 16
    assert within(16, MOST_BYTES // 5) == 5
    assert within(16, 10 * MOST_BYTES) == LEAST_KEPT
