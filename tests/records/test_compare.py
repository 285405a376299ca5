"""Records held against each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.records.compare import differences, profile_difference
from avahazard.records.event import Event
from avahazard.records.path import Profile

EVENT = Event("e", "P", runout_x_m=0.1 + 0.2, covariates={"a": 1.0})
PROFILE = Profile("P", np.arange(5.0), -np.arange(5.0), crs="A", lon=np.ones(5), lat=np.ones(5))


def test_numbers_are_compared_to_the_last_bit() -> None:
    assert differences(EVENT, replace(EVENT)) == []
    assert differences(EVENT, replace(EVENT, runout_x_m=0.3)) == [("runout_x_m", 0.1 + 0.2, 0.3)]


def test_covariates_are_compared_by_column() -> None:
    other = replace(EVENT, covariates={"b": "x"})
    assert differences(EVENT, other) == [("a", 1.0, None), ("b", None, "x")]


@pytest.mark.parametrize(
    ("other", "place", "column"),
    [
        (replace(PROFILE, y_m=np.array([0, -1, -2.5, -3, -4])), 2, "y_m"),
        (replace(PROFILE, crs="B"), 0, "crs"),
        (replace(PROFILE, lon=None), 0, "lon"),
        (replace(PROFILE, land_cover=("open",) * 5), 0, "land_cover"),
        (
            Profile("P", np.arange(4.0), -np.arange(4.0), crs="A", lon=np.ones(4), lat=np.ones(4)),
            3,
            "path_id",
        ),
    ],
)
def test_the_first_different_point_is_found(other: Profile, place: int, column: str) -> None:
    found = profile_difference(PROFILE, other)
    assert found is not None
    assert (found[0], found[1][0]) == (place, column)


def test_equal_profiles() -> None:
    assert profile_difference(PROFILE, replace(PROFILE, y_m=PROFILE.y_m.copy())) is None
