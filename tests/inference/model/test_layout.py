"""The parameters of a model: order, bounds, prior, readable names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from avahazard.effects.groups import SPREAD
from avahazard.inference.fitting.mode import log_prior_mass
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import TRACK_RANGE, Arms, with_arms
from avahazard.inference.model.specification import GivenPrior
from tests.inference.studies import near, observations, posterior


def test_coordinates_are_law_scatter_effects_and_speed() -> None:
    layout = posterior(
        observations(), "snow-type", "path-effect", "entrainment", scatter="volume", law="rational"
    ).layout
    assert [s.name for s in layout.slots] == [
        "log a",
        "log c in 1e5 m3",
        "log n",
        "log sigma",
        "sigma_n",
        "snow-type.mixed",
        "snow-type.wet",
        "tau",
        "entrainment.rate",
        "entrainment.above",
        "log track sigma",
    ]
    assert (layout.scatter, layout.scatter_slope) == (3, 4)
    assert (layout.spreads, layout.track_scatter) == ({"path-effect": 7}, 10)
    assert layout.places == {"snow-type": slice(5, 7), "entrainment": slice(8, 10)}
    assert layout.tables == (8, 9)
    assert (layout.slots[10].low, layout.slots[10].high) == TRACK_RANGE


def test_without_speeds_there_is_no_scatter_of_speeds() -> None:
    layout = posterior(observations(speeds=False)).layout
    assert layout.track_scatter is None
    assert [s.name for s in layout.slots] == ["log a", "n in 1e-6/m3", "log sigma"]


def test_the_prior_is_normal_in_every_coordinate() -> None:
    layout = posterior(observations(), "turbulent-drag").layout
    u, other = np.array([-0.5, 2.0, -1.5, 0.4, 1.0]), np.array([-0.7, 0.0, -2.0, 0.1, 2.0])
    sd = np.array([0.5, 10.0, 1.0, 1.0, 1.0])
    mean = np.array([np.log(0.5), 0.0, np.log(0.15), 0.0, np.log(0.075)])
    expected = np.sum(stats.norm.logpdf(u, mean, sd) - stats.norm.logpdf(other, mean, sd))
    assert layout.log_prior(u) - layout.log_prior(other) == pytest.approx(expected)


def test_people_read_parameters_in_their_units() -> None:
    model = posterior(observations(), "turbulent-drag", "path-effect", scatter="volume")
    u = near(model, **{"turbulent-drag.drag": 0.6, "sigma_n": 0.5, "tau": 1.5})
    read = model.layout.readable(np.stack([u, u]))
    values = {name: float(v[1]) for name, (v, _) in read.items()}
    assert values == pytest.approx(
        {
            "a": np.exp(-0.8),
            "n": 1e-6,
            "sigma": 0.15,
            "sigma_n": 0.5 / model.layout.reference_volume,
            "turbulent-drag.drag": 0.003,
            "path-effect.tau": 1.5 * SPREAD,
            "track_sigma": 0.075,
        }
    )
    units = {name: unit for name, (_, unit) in read.items()}
    assert (units["n"], units["sigma_n"], units["track_sigma"]) == ("1/m3", "1/m3", "friction")
    assert units["turbulent-drag.drag"] == "1/m"


def test_scatter_of_a_normal_law_is_of_friction_itself() -> None:
    assert posterior(observations(), distribution="normal").layout.readable(np.zeros(4))["sigma"][
        1
    ] == ("friction")


def test_values_are_exactly_neutral_where_coordinates_are() -> None:
    model = posterior(
        observations(), "speed-weakening", "epoch-bias", "entrainment", "leading-edge"
    )
    values = model.layout.effect_values(near(model))
    for effect in model.effects:
        assert np.array_equal(values[effect.key], effect.neutral)


def test_other_grids_are_other_ranges() -> None:
    layout = posterior(observations(), "cohesion").layout
    k = layout.tables[0]
    finer = with_arms(layout, Arms({"cohesion.strength": (0.2, 0.3, 0.4)}))
    assert finer.slots[k].arm == (0.2, 0.3, 0.4)
    assert (finer.low[k], finer.high[k]) == (0.2, 0.4)
    assert (layout.low[k], layout.high[k]) == (0.0, 3.5)
    assert finer.slots[:k] == layout.slots[:k]


def test_a_prior_that_is_given_to_a_spread_is_lognormal() -> None:
    told = (GivenPrior("path-effect.tau", 0.1, 0.05), GivenPrior("sigma_n", 2e-6, 1e-6))
    bare = posterior(observations(), "path-effect", scatter="volume")
    made = Posterior(bare.observations, replace(bare.specification, given=told), bare.effects)
    layout = made.layout
    k, volume = layout.spreads["path-effect"], layout.scatter_slope
    assert volume is not None
    mean, sd = told[0].in_log
    tau = np.array([0.02, 0.1, 0.3])
    at = np.tile([s.mean for s in layout.slots], (3, 1))
    at[:, k] = tau / layout.slots[k].scale
    # A density of the coordinate, which is τ times a constant.
    density = stats.lognorm.logpdf(tau, sd, scale=np.exp(mean))
    np.testing.assert_allclose(np.diff(layout.log_prior(at)), np.diff(density))
    slope = layout.prior_slopes(at[1])[k]
    step = 1e-6 * np.eye(len(layout.slots))[k]
    away = layout.log_prior(np.array([at[1] - step, at[1] + step]))
    assert slope == pytest.approx(np.diff(away)[0] / 2e-6, rel=1e-6)
    # Its mass is what evidence divides by.
    u = np.linspace(layout.slots[k].low, layout.slots[k].high, 400_001)
    z = (np.log(u) - layout.slots[k].mean) / layout.slots[k].sd
    slot, half = layout.slots[k], np.log(np.trapezoid(np.exp(-0.5 * z**2) / u, u))
    other = np.log(np.sqrt(np.pi / 2.0)) - np.log(layout.slots[volume].sd)
    assert log_prior_mass(made) - log_prior_mass(bare) == pytest.approx(half - other, abs=0.02)
    assert slot.lognormal
    # σ_n has either sign: the normal of those numbers, in 1/m3.
    slot = layout.slots[volume]
    reference = layout.reference_volume
    assert (slot.mean, slot.sd) == pytest.approx((2e-6 * reference, 1e-6 * reference))
