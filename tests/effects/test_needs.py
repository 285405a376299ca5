"""What effects need of the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.needs import level_counts, needs_profile, needs_volume
from tests.effects.event_table import event_table
from tests.effects.examples import columns


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
