"""Volumes that dwarf all others."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.dwarfing import dwarfing

USUAL = [1e3, 2e4, 1e5, 3e5, 8e5]


@pytest.mark.parametrize(
    ("volumes", "found"),
    [
        (USUAL, []),
        ([*USUAL, 8e8], [5]),
        ([8e8, *USUAL], [0]),
        ([*USUAL, 5e7], []),
        ([*USUAL, 8e8, 9e8], []),  # two of seven are no slips
        ([*USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, *USUAL, 9e8, 8e8], [40, 41]),
        ([1e3, np.nan, 8e8], []),
        ([*USUAL, np.nan], []),
    ],
)
def test_a_few_beyond_a_gap(volumes: list[float], found: list[int]) -> None:
    assert dwarfing(np.log(np.array(volumes))).tolist() == found
