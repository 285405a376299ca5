"""Where friction lies and how it scatters, written out."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.friction_model import MOST_LOG_SCATTER
from avahazard.inference.model.laws import LAWS
from tests.inference.studies import near, observations, posterior


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
def test_the_law_at_the_volume_with_the_design_of_an_effect(distribution: str) -> None:
    model = posterior(observations(), "snow-type", distribution=distribution)
    u = near(model, 0.2, 3)
    location, scatter = model.location_and_scatter(u)
    volume = observations().volumes.volume
    shift = np.zeros(len(volume))
    for place, design in model.of_events.shifts:
        shift = shift + design @ u[place]
    assert np.ptp(shift) > 0.0
    # log μ = log a - n V, n in 1e-6 a cubic metre.
    expected = u[0] - 1e-6 * u[1] * volume + shift[:, None]
    in_log = distribution == "lognormal"
    np.testing.assert_allclose(location, expected if in_log else np.exp(expected))
    np.testing.assert_allclose(scatter, np.exp(u[model.layout.scatter]))


def test_scatter_that_changes_with_volume_stays_within_its_bounds() -> None:
    model = posterior(observations(), scatter="volume")
    layout = model.layout
    u = near(model)
    volume = np.array([[1e-6], [layout.reference_volume], [10.0 * layout.reference_volume]])
    share = [0.0, 1.0, 1.0]
    for slope in (0.7, -0.4):
        u[layout.scatter_slope] = slope
        _, scatter = model.location_and_scatter(u, volume)
        expected = [
            max(u[layout.scatter] - slope * s, layout.slots[layout.scatter].low) for s in share
        ]
        np.testing.assert_allclose(np.log(scatter[:, 0]), expected, atol=1e-6)
    u[layout.scatter_slope] = 50.0
    _, least = model.location_and_scatter(u, volume)
    assert np.log(least[1, 0]) == pytest.approx(layout.slots[layout.scatter].low)
    u[layout.scatter_slope] = -50.0
    _, most = model.location_and_scatter(u, volume)
    assert np.log(most[1, 0]) == pytest.approx(MOST_LOG_SCATTER)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_that_is_a_line_may_take_its_covariate(name: str) -> None:
    given = observations()
    model = posterior(given, "snow-type", law=name)
    u, volume = near(model, 0.2, 3), given.volumes.volume
    covariate = model.friction.line_covariate(volume)
    assert (covariate is not None) == (name in ("exponential", "power"))
    expected = model.friction.location_and_scatter(u, volume, model.of_events)
    for found in (
        model.friction.location_and_scatter(u, volume, model.of_events, covariate),
        model.location_and_scatter(u),
    ):
        np.testing.assert_array_equal(found[0], expected[0])
        np.testing.assert_array_equal(found[1], expected[1])
