"""Friction of single volumes, and whether it rises with volume."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.volume_friction import friction_of_volumes, rising_friction
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel
from tests.hazard.parabola import TOP_M, draws, observations

RELEASES = (TOP_M, 2350.0)


def model(u: np.ndarray) -> FittedModel:
    return FittedModel(Posterior(observations(RELEASES), Specification(), ()), u, {}, "marginal")


def test_every_class_has_the_friction_of_every_volume() -> None:
    u = draws(0.1, 3)
    u[:, 0] += [0.0, 0.1, 0.3]
    volume = np.array([1e4, 5e4, 2e5])
    location, scatter = friction_of_volumes(model(u).posterior, u, volume)
    assert location.shape == scatter.shape == (3, 2, 3)
    expected = u[:, 0, None] - 1e-6 * u[:, 1, None] * volume
    for k in range(2):
        np.testing.assert_allclose(location[:, k], expected)
    np.testing.assert_allclose(scatter, 0.1)


def test_friction_rises_in_the_draws_whose_law_does() -> None:
    u = draws(0.1, 4)
    u[:, 1] = [2.0, 1.0, -1.0, 3.0]
    found = rising_friction(model(u), u, np.log([np.nan, 3e4, 1e4, 2e5]))
    assert found is not None
    assert found.share == 0.25
    assert (found.smallest_m3, found.largest_m3) == pytest.approx((1e4, 2e5))


@pytest.mark.parametrize("volumes", [[np.nan, np.nan], [1e4, 1e4, np.nan]])
def test_volumes_that_are_alike_tell_nothing(volumes: list[float]) -> None:
    u = draws(0.1, 2)
    assert rising_friction(model(u), u, np.log(volumes)) is None
