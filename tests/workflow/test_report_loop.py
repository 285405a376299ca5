"""What the suspect's picture is made of."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import MotionEffect
from avahazard.effects.motion import state_at
from avahazard.effects.site import path_site
from avahazard.physics.cells import SPEEDS
from avahazard.records.collection import Path, Profile
from avahazard.workflow.report_loop import force_by_speed

X = np.arange(0.0, 2001.0, 20.0)
SITE = path_site(Path("P"), Profile("P", X, 1500.0 - 0.9 * X + 1.5e-4 * X**2))


def effect(key: str) -> MotionEffect:
    return cast(MotionEffect, catalogue()[key].build({"bottom_m": 500.0, "top_m": 1500.0}))


@pytest.mark.parametrize(
    ("key", "expected"), [("turbulent-drag", 0.01 * SPEEDS**2), ("cohesion", 0.01)]
)
def test_a_force_by_speed_alone_is_its_own_curve(key: str, expected: np.ndarray | float) -> None:
    found = force_by_speed(effect(key), SITE, np.array([0.01]))
    assert found is not None
    np.testing.assert_allclose(found, np.broadcast_to(expected, SPEEDS.shape))


@pytest.mark.parametrize(
    ("key", "values"), [("entrainment", [0.01, 1200.0]), ("speed-weakening", [0.5, 10.0])]
)
def test_what_the_place_or_friction_matters_to_is_no_such_force(
    key: str, values: list[float]
) -> None:
    assert force_by_speed(effect(key), SITE, np.array(values)) is None


def test_states_are_those_of_the_ground() -> None:
    at = np.array([400.0, 1000.0])
    slope = np.degrees(np.arctan(0.9 - 3e-4 * at))
    np.testing.assert_allclose(state_at("slope", SITE, at), slope, atol=1.0)
    np.testing.assert_allclose(state_at("distance", SITE, at), at, atol=20.0)
