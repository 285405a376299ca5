"""Stops of runs over friction and volume."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.simulation import Simulation, StopTable, stop_table


def _run(friction: float, volume: float, stop: float, *, left: bool = False) -> Simulation:
    return Simulation("P", "com1dfa", "", friction, volume, 0.0, stop, left, 1.0)


def _table() -> StopTable:
    runs = [
        _run(0.2, 1e3, 900.0),
        _run(0.4, 1e3, 500.0),
        _run(0.2, 1e5, 1000.0, left=True),
        _run(0.4, 1e5, 700.0),
        _run(0.6, 1e5, np.nan),
    ]
    return stop_table(runs, 100.0, 1000.0)


def test_friction_goes_straight_in_places_and_log_volume() -> None:
    table = _table()
    assert table.at(1e3, np.array([0.2, 0.3, 0.4])) == pytest.approx([900.0, 700.0, 500.0])
    assert table.at(1e4, np.array([0.4])) == pytest.approx([580.0])
    assert table.at(1e5, np.array([0.5, 0.6])) == pytest.approx([400.0, 100.0])  # did not move


def test_what_passes_the_end_has_left_and_the_ends_of_the_table_count_beyond_it() -> None:
    table = _table()
    assert table.at(1e5, np.array([0.2]))[0] == np.inf
    assert table.at(1e7, np.array([0.4])) == pytest.approx([700.0])
    assert table.at(1e3, np.array([0.1, 0.9])) == pytest.approx([900.0, 500.0])


def test_more_friction_never_carries_farther() -> None:
    table = stop_table([_run(0.2, 1e3, 500.0), _run(0.3, 1e3, 510.0)], 0.0, 1000.0)
    assert table.at(1e3, np.array([0.2, 0.3])) == pytest.approx([510.0, 510.0])
