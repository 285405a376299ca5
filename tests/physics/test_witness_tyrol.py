"""Stops and speeds against scipy's integrator in time, on every Tyrol profile."""

from __future__ import annotations

import pytest

from avahazard.physics.smooth_profile import smooth_profile
from tests.physics.comparing import compare
from tests.physics.paths import read_profiles

TYROL = ["alr", "gar", "gar23", "gar2345", "hit_downvalley", "hit_upvalley", "kot", "mal", "wog"]


LONG = ("alr", "gar23", "gar2345", "hit_downvalley", "hit_upvalley", "kot", "mal", "gar")
"""Profiles whose runs by the witness take longest."""


@pytest.mark.parametrize(
    "path", [pytest.param(p, marks=pytest.mark.slow) if p in LONG else p for p in TYROL]
)
def test_tyrol(path: str, shared_data) -> None:
    profiles = read_profiles(shared_data / "tyrol-profiles" / "profiles.csv")
    assert sorted(profiles) == TYROL
    x, y = profiles[path]
    release = x[20] if path == "hit_downvalley" else x[0]  # its top is flat
    compare(smooth_profile(x, y), release, 50 if path in LONG else 20)
