"""The friction of an event by its own record, against the sum written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.scoring.friction_given_record import friction_given_record
from avahazard.physics.runout_curve import MU

SHARE = np.array([0.3, 0.7])
LOCATION, SCATTER = np.array([-0.9, -0.7]), np.array([0.1, 0.2])


def model(tails: str = "normal") -> Any:
    """A posterior of two volumes for its one event."""
    return SimpleNamespace(
        layout=SimpleNamespace(log_scatter=True),
        specification=SimpleNamespace(tails=tails),
        observations=SimpleNamespace(volumes=SimpleNamespace(weight=SHARE[None])),
    )


def nodes(place: list[float], weight: list[float], left: bool) -> Any:
    """Nodes of that event."""
    return SimpleNamespace(
        place=np.array([place]),
        weight=np.array([weight]),
        is_probability=np.array([left]),
        floor=np.zeros(1),
        tail=np.zeros((1, 2)),
        tail_place=np.log([[0.02, 1.6]]),
    )


@pytest.mark.parametrize("tails", ["normal", "student"])
def test_chances_are_the_record_times_the_scatter(tails: str) -> None:
    place, weight = [-1.0, -0.8, -0.5], [0.2, 0.5, 0.3]
    mu, chance = friction_given_record(
        model(tails), nodes(place, weight, left=False), 0, LOCATION, SCATTER
    )
    expected = []
    for x, w in zip(place, weight, strict=True):
        total = 0.0
        for k in range(2):
            z = (x - LOCATION[k]) / SCATTER[k]
            bell = np.exp(-0.5 * z * z) if tails == "normal" else (1.0 + z * z / 4.0) ** -2.5
            total += SHARE[k] * bell / SCATTER[k]
        expected.append(w * total)
    np.testing.assert_allclose(mu[:3], np.exp(place))
    np.testing.assert_allclose(chance, [*np.array(expected) / sum(expected), 0.0, 0.0])


def test_what_left_has_any_friction_below_the_edge() -> None:
    edge = float(np.log(0.4))
    mu, chance = friction_given_record(
        model(), nodes([edge, -3.0], [1.0, 0.0], left=True), 0, LOCATION, SCATTER
    )
    np.testing.assert_allclose(mu[:-2], MU)
    assert chance.sum() == pytest.approx(1.0)
    assert np.all(chance[mu > 0.4 + 1e-9] == 0.0)
    assert np.sum(mu * chance) < 0.4
