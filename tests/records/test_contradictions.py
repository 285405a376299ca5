"""Values of one event that cannot all be true."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.contradictions import place_fault, volume_fault
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile

SLOPE = Profile("P", np.array([0.0, 500.0, 1000.0]), np.array([1500.0, 1250.0, 1000.0]))
DEPOSIT = {"deposit_length_m": 100.0, "deposit_width_m": 20.0, "deposit_thickness_m": 3.0}


@pytest.mark.parametrize(
    ("volume", "sigma", "fault"),
    [
        (3000.0, 0.5, False),
        (10_000.0, 0.5, False),
        (15_000.0, 0.5, True),
        (500.0, 0.5, True),
        (5000.0, 0.01, False),
        (7000.0, 0.01, True),
        (None, 0.5, False),
    ],
)
def test_volume_and_deposit(volume: float | None, sigma: float, fault: bool) -> None:
    event = Event("e", "P", volume_m3=volume, volume_rel_sigma=sigma, **DEPOSIT)
    assert (volume_fault(event) is not None) is fault


@pytest.mark.parametrize(
    ("event", "column"),
    [
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1100), None),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1140), None),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1200), "runout_elevation_m"),
        (Event("e", "P", runout_x_m=800, runout_elevation_m=1200, runout_sigma_m=60), None),
        (Event("e", "P", left_profile=True), None),
        (Event("e", "P", left_profile=True, runout_x_m=990), None),
        (Event("e", "P", left_profile=True, runout_x_m=1200), None),
        (Event("e", "P", left_profile=True, runout_x_m=500), "runout_x_m"),
        (Event("e", "P", left_profile=True, runout_elevation_m=1200), "runout_elevation_m"),
        (Event("e", "P", left_profile=True, runout_elevation_m=900), None),
        (Event("e", "P", runout_x_m=100, release_elevation_m=1300), "runout_x_m"),
        (Event("e", "P", runout_x_m=420, release_elevation_m=1300), None),
        (Event("e", "P", runout_elevation_m=1400, release_elevation_m=1300), "runout_elevation_m"),
        (Event("e", "P", runout_x_m=100), "runout_x_m"),
    ],
)
def test_places(event: Event, column: str | None) -> None:
    found = place_fault(event, Path("P", release_elevation_m=1350), SLOPE)
    assert (found and found[0]) == column


def test_the_top_of_the_profile_is_above_every_stop() -> None:
    assert place_fault(Event("e", "P", runout_x_m=5), Path("P"), SLOPE) is None
    assert place_fault(Event("e", "P", runout_x_m=5), None, SLOPE) is None
