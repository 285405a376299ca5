"""Where friction lies and how it scatters, written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.model.friction_model import MOST_LOG_SCATTER, below
from avahazard.inference.model.laws import LAWS
from avahazard.inference.seeds import generator
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
        _, scatter = model.friction.location_and_scatter(u, volume, model.of_events)
        expected = [
            max(u[layout.scatter] - slope * s, layout.slots[layout.scatter].low) for s in share
        ]
        np.testing.assert_allclose(np.log(scatter[:, 0]), expected, atol=1e-6)
    u[layout.scatter_slope] = 50.0
    _, least = model.friction.location_and_scatter(u, volume, model.of_events)
    assert np.log(least[1, 0]) == pytest.approx(layout.slots[layout.scatter].low)
    u[layout.scatter_slope] = -50.0
    _, most = model.friction.location_and_scatter(u, volume, model.of_events)
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


@pytest.mark.parametrize("settings", [{}, {"distribution": "normal"}, {"tails": "student"}])
def test_draws_of_two_kinds_have_the_density_of_the_likelihood(settings: dict[str, str]) -> None:
    model = posterior(observations(), "two-kinds", **settings)
    friction, n = model.friction, 40_000
    u = near(model, **{"two-kinds.share": 1.0, "two-kinds.shift": -1.5})
    events = model.of_events
    volume = np.full((observations().n_events, 1), 3e4)
    law, scatter = friction.location_and_scatter(u, volume, events)
    location, _ = friction.by_kind(u, law, scatter)
    weight = friction.weights_by_kind(u, np.ones((1, 1)))[0]
    assert weight.sum() == pytest.approx(1.0)
    if model.layout.log_scatter:
        # The law stays the mean of both.
        assert location[0] @ weight == pytest.approx(law[0, 0])
        assert location[0, 1] - location[0, 0] == pytest.approx(-0.45)
    drawn = friction.draw(
        u, np.full(n, law[0, 0]), np.full(n, scatter[0, 0]), generator(0, "kinds")
    )
    nu = np.log(drawn) if model.layout.log_scatter else drawn
    chance = below((nu[:, None] - location[0]) / scatter[0, 0], friction.student) @ weight
    assert stats.kstest(chance, "uniform").pvalue > 0.01
    # Of as many coordinates each draws its own.
    many = friction.draw(
        np.tile(u, (n, 1)), np.full(n, law[0, 0]), np.full(n, scatter[0, 0]), generator(0, "kinds")
    )
    np.testing.assert_array_equal(many, drawn)
