"""Runs near some stops alone against runs with every friction."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.near_stops import MARGIN, SLOW_MARGIN, Asked, NearStops, near_stops
from avahazard.physics.resistance import SPEEDS
from avahazard.physics.runout_curve import MU, RunoutCurve, tabulate
from tests.physics.paths import bowl, cells_of, ski_jump, terrain_of

WEAKENING = 0.5 + 0.5 / (1.0 + SPEEDS / 8.0)
GROUNDS = {
    "bowl": cells_of(terrain_of(bowl()), drag=1e-3),
    "jump": cells_of(terrain_of(ski_jump()), drag=1e-3),
    "by speed": cells_of(terrain_of(bowl(), max_cell=10.0), speed_factor=WEAKENING),
}


def setting(name: str, low: float, high: float, middle: int) -> tuple[NearStops, RunoutCurve]:
    cells = GROUNDS[name]
    starts = np.array([np.flatnonzero(cells.x == 100.0)[0]])
    asked = Asked(np.array([low]), np.array([high]), np.array([middle]))
    return near_stops(cells, starts, MU, asked), tabulate(cells, starts)


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_all_that_stops_there_is_run_and_its_neighbours(name: str, share: float) -> None:
    x = GROUNDS[name].x
    low = x[0] + share * (x[-1] - x[0])
    found, whole = setting(name, low, low + 60.0, 100)
    rows = slice(found.first[0], found.end[0])
    np.testing.assert_array_equal(found.curve.x[0, rows], whole.x[0, rows])
    np.testing.assert_array_equal(found.curve.y[0, rows], whole.y[0, rows])
    np.testing.assert_array_equal(found.curve.status[0, rows], whole.status[0, rows])
    beyond = np.flatnonzero(whole.left[0] | (whole.x[0] > low + 60.0))[-1]
    short = np.flatnonzero(whole.x[0] < low)[0]
    margin = SLOW_MARGIN if name == "by speed" else MARGIN
    assert found.first[0] == max(beyond - margin, 0)
    assert found.end[0] == min(short + 1 + margin, len(MU))
    assert found.end[0] - found.first[0] < len(MU) // 3


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("high", [1500.0, np.inf])
def test_it_is_the_same_wherever_it_begins(name: str, high: float) -> None:
    first = setting(name, 1300.0, high, 0)[0]
    for middle in (150, 400, len(MU)):
        other = setting(name, 1300.0, high, middle)[0]
        np.testing.assert_array_equal(first.curve.x, other.curve.x)
        np.testing.assert_array_equal(first.curve.status, other.curve.status)
        assert (first.first, first.end) == (other.first, other.end)


def test_beyond_the_ends_are_repeated() -> None:
    found, whole = setting("bowl", 1300.0, 1400.0, 300)
    first, end = found.first[0], found.end[0]
    assert 0 < first < end < len(MU)
    assert np.all(found.curve.x[0, :first] == whole.x[0, first])
    assert np.all(found.curve.x[0, end:] == whole.x[0, end - 1])
    assert np.all(found.curve.status[0, end:] == whole.status[0, end - 1])


def test_what_left_is_past_every_place_unless_it_is_asked_for() -> None:
    whole = setting("bowl", 0.0, 0.0, 0)[1]
    last = int(np.flatnonzero(whole.left[0])[-1])
    end_x = GROUNDS["bowl"].x[-1]
    found = setting("bowl", end_x - 1.0, end_x, 300)[0]
    assert found.first[0] == last - MARGIN
    assert setting("bowl", end_x - 1.0, np.inf, 300)[0].first[0] == 0
