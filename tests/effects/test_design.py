"""Effects on friction: the columns that are added to its log."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.arrays import Floats
from avahazard.effects.covariate import RELEASE_ELEVATION, SEASON
from avahazard.effects.effect import Definition, FrictionEffect
from avahazard.records.collection import Event
from tests.effects.examples import columns, sites


def _design(entry: Definition, table=None) -> Floats:
    """The design columns; what the effect takes from the data is from all the events."""
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, FrictionEffect)
    return effect.design(columns() if table is None else table)


def test_release_elevations_count_in_kilometres_from_2000_m() -> None:
    table = columns((Event("a", "P0"), Event("b", "P0")))
    table.release_elevation[:] = [2500.0, np.nan]
    assert _design(RELEASE_ELEVATION, table)[:, 0].tolist() == [0.5, 0.0]


def test_the_winter_is_a_parabola_about_its_middle() -> None:
    dates = ("1950-01-30", "1950-03-31", "1949-12-01", "1950")
    table = columns(tuple(Event(d, "P0", date=d) for d in dates))
    t = np.array([0.0, 1.0, -1.0, 0.0])
    assert _design(SEASON, table) == pytest.approx(np.column_stack([t, t**2]))
