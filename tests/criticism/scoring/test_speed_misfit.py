"""Speeds along tracks, and the force they tell of."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.scoring.speed_misfit import (
    friction_given_record,
    matched_speeds,
    measured_force,
    speed_misfit,
)
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.model.observations import build_observations
from avahazard.physics.cells import GRAVITY
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Speed
from tests.criticism.studies import draws_about, fitted, slopes, with_left, with_speeds


def test_friction_is_that_of_the_stop() -> None:
    """The predicted speeds are those of a run with the friction that F(μ) gives for the record."""
    posterior, mode = fitted(with_speeds(slopes(n_paths=1, n_each=12)))
    u = np.repeat(mode.u[None, :], 30, axis=0)
    u[:, posterior.layout.track_scatter] = posterior.layout.slots[-1].low
    found = matched_speeds(fitted_model(posterior, u, {}), np.random.default_rng(1))
    assert found is not None
    table = posterior.nodes.predicted_at(mode.u)
    mu = np.interp(posterior.observations.observed[0], table.record[0], MU)
    by_hand = [np.interp(mu, MU, column) for column in table.speeds[0].speed.T]
    np.testing.assert_allclose(found.draws.mean(axis=1), by_hand, atol=0.4)
    # The error of speed, 1 m/s and the least of the model, and a little from that of the stop.
    spread = found.draws.std(axis=1)
    assert np.all((spread > 0.95) & (spread < 1.5))


def test_a_measured_speed_does_not_fit_itself() -> None:
    slow, mode = fitted(with_speeds(slopes(n_paths=1, n_each=12), 10.0))
    fast, _ = fitted(with_speeds(slopes(n_paths=1, n_each=12), 30.0))
    u = draws_about(mode, 100)
    u = np.clip(u, slow.layout.low, slow.layout.high)
    one = matched_speeds(fitted_model(slow, u, {}), np.random.default_rng(2))
    other = matched_speeds(fitted_model(fast, u, {}), np.random.default_rng(2))
    assert one is not None
    assert other is not None
    np.testing.assert_array_equal(one.draws, other.draws)
    assert np.all(one.observed < other.observed)


def test_an_event_that_left_ran_faster() -> None:
    records = slopes(n_paths=1, n_each=12)
    stopped, mode = fitted(with_speeds(records))
    left, _ = fitted(with_speeds(with_left(records)))
    u = np.repeat(mode.u[None, :], 30, axis=0)
    one = matched_speeds(fitted_model(stopped, u, {}), np.random.default_rng(3))
    other = matched_speeds(fitted_model(left, u, {}), np.random.default_rng(3))
    assert one is not None
    assert other is not None
    assert other.draws[2].mean() > one.draws[2].mean()


def test_none_without_tracks() -> None:
    posterior, mode = fitted(slopes())
    rng = np.random.default_rng(4)
    assert matched_speeds(fitted_model(posterior, draws_about(mode), {}), rng) is None


def test_force_of_a_coulomb_block_on_a_slope() -> None:
    """On an even slope a block of friction μ has u² = 2 g (sinθ - μ cosθ) ξ."""
    records = slopes(n_paths=1, n_each=1)
    x = np.linspace(0.0, 1000.0, 51)
    profile = replace(records.profiles[0], x_m=x, y_m=1000.0 - 0.8 * x)
    mu, angle = 0.4, np.arctan(0.8)
    places = np.arange(100.0, 401.0, 10.0)
    w = 2.0 * GRAVITY * (np.sin(angle) - mu * np.cos(angle)) * places / np.cos(angle)
    event = replace(records.events[0], runout_elevation_m=300.0)
    speeds = tuple(
        Speed("0-0", float(u), 0.5, x_m=float(p)) for p, u in zip(places, np.sqrt(w), strict=True)
    )
    records = replace(records, profiles=(profile,), events=(event,), speeds=speeds)
    rows = measured_force(build_observations(records))
    assert len(rows) == 15
    for row in rows:
        assert row.force_m_s2 == pytest.approx(mu * GRAVITY * np.cos(angle), rel=1e-6)
        assert row.slope_deg == pytest.approx(np.degrees(angle))
        assert row.sd_m_s2 > 0.0


def test_misfit_by_place_and_by_predicted_speed() -> None:
    posterior, mode = fitted(with_speeds(slopes(n_paths=1, n_each=12)))
    u = np.clip(draws_about(mode, 50), posterior.layout.low, posterior.layout.high)
    found = matched_speeds(fitted_model(posterior, u, {}), np.random.default_rng(5))
    assert found is not None
    rows = speed_misfit(posterior.observations, found)
    assert {row.axis for row in rows} == {"place_along_path", "predicted_speed_m_s"}
    from_low_to_high = ["up_to", "from_to", "above"]
    for axis in ("place_along_path", "predicted_speed_m_s"):
        levels = [row.level for row in rows if row.axis == axis]
        assert [level.key for level in levels] == from_low_to_high[: len(levels)]
    assert sum(row.n for row in rows if row.axis == "place_along_path") == 3
    total = sum(row.n * row.bias_m_s for row in rows[:3])
    assert total == pytest.approx(np.sum(found.draws.mean(axis=1) - found.observed))


SHARE = np.array([0.3, 0.7])
LOCATION, SCATTER = np.array([-0.9, -0.7]), np.array([0.1, 0.2])


def model(tails: str = "normal") -> Any:
    """A posterior of two volumes for its one event."""
    return SimpleNamespace(
        layout=SimpleNamespace(log_scatter=True), specification=SimpleNamespace(tails=tails)
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
        model(tails),
        nodes(place, weight, left=False),
        0,
        (LOCATION[None], SCATTER[None], SHARE[None]),
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
        model(),
        nodes([edge, -3.0], [1.0, 0.0], left=True),
        0,
        (LOCATION[None], SCATTER[None], SHARE[None]),
    )
    np.testing.assert_allclose(mu[:-2], MU)
    assert chance.sum() == pytest.approx(1.0)
    assert np.all(chance[mu > 0.4 + 1e-9] == 0.0)
    assert np.sum(mu * chance) < 0.4
