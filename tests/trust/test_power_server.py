"""Power cuts of a server: a short study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.trust.power_server import can_cut_server, cut_server_power

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not can_cut_server(), reason="there is no gcc, or no PostgreSQL"),
]


def test_what_a_server_confirmed_outlives_a_power_cut(tmp_path: Path) -> None:
    found = cut_server_power(tmp_path, 10, np.random.default_rng(2), model=False)
    assert found.n_confirmed > 0
    assert (found.lost, found.partial, found.damaged) == (0, 0, 0)


def test_the_study_sees_a_server_that_does_not_wait_for_the_disk(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    assert cut_server_power(tmp_path, 30, rng, synchronous="off", model=False).lost > 0
