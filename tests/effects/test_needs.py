"""What effects need of the data."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.columns import build_columns
from avahazard.effects.needs import level_counts, needs_profile, needs_volume
from avahazard.records.event import Event
from avahazard.records.path import Path
from tests.effects.event_table import event_table
from tests.effects.examples import columns

PATHS = {name: Path(name) for name in "AB"}


@pytest.mark.parametrize(
    ("log_volume", "enough"),
    [([9.0, 10.0], True), ([9.0, np.nan], False), ([9.0, 9.0], False), ([np.nan] * 2, False)],
)
def test_volumes_must_differ(log_volume: list[float], enough: bool) -> None:
    table = replace(event_table(a=[0.0, 1.0]), log_volume=np.array(log_volume))
    assert (needs_volume(table, ()) is None) == enough


def test_a_profile_is_that_of_an_events_path() -> None:
    assert needs_profile(columns(), ()) is None
    assert needs_profile(event_table(), ()) is not None


def test_missing_values_are_no_level() -> None:
    assert level_counts(np.array(["b", "", "a", "b", ""])) == {"a": 1, "b": 2}


@pytest.mark.parametrize(
    ("n_stops", "declared", "enough"), [(4, None, False), (5, None, True), (1, 900.0, True)]
)
def test_a_limit_of_sight_takes_some_stops_of_a_path_or_is_declared(
    n_stops: int, declared: float | None, enough: bool
) -> None:
    stops = np.full(11, np.nan)
    stops[:n_stops] = 500.0
    stops[-4:] = 600.0
    path = np.repeat([0, 1], [7, 4])
    table = replace(
        build_columns([Event(str(i), "AB"[k]) for i, k in enumerate(path)], PATHS, np.zeros(11)),
        stop_elevation=stops,
    )
    sites: Any = [
        SimpleNamespace(path=Path("A", observed_below_m=declared)),
        SimpleNamespace(path=Path("B")),
    ]
    lack = definition("observation-limit").lacking(table, sites)
    assert (lack is None) == enough
    assert lack is None or "5 stops" in lack
