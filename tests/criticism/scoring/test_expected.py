"""Records to be expected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.scoring.scores import (
    error_sign,
    expected_records,
    observed_records,
    profile_end,
)
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.prediction import predict_stops
from tests.criticism.studies import draws_about, fitted, slopes, straight, with_left


def test_draws_hold_scatter_and_the_error_of_the_record() -> None:
    posterior, mode = fitted(straight())
    u = np.repeat(mode.u[None, :], 10, axis=0)
    sigma = 300.0
    posterior.observations.sigma[:] = sigma
    found = expected_records(fitted_model(posterior, u, {}), 20_000, np.random.default_rng(1))
    log_mu, scatter = mode.u[0], np.exp(mode.u[1])
    mean = 1000.0 * np.exp(-log_mu + 0.5 * scatter**2)
    spread = mean * np.sqrt(np.exp(scatter**2) - 1.0)
    assert found.draws[0].mean() == pytest.approx(mean, rel=0.01)
    assert found.draws[0].std() == pytest.approx(np.hypot(spread, sigma), rel=0.03)


def test_what_left_counts_as_reaching_the_end() -> None:
    for kind, end in (("elevation", 1000.0 - 1800.0 + 2.5e-4 * 1800.0**2), ("x", 1800.0)):
        posterior, mode = fitted(with_left(slopes(kind=kind)))
        observations = posterior.observations
        found = expected_records(
            fitted_model(posterior, draws_about(mode), {}), 500, np.random.default_rng(2)
        )
        assert np.any(found.left)
        assert np.any(~found.left)
        np.testing.assert_allclose(found.draws[1][found.left[1]], end, atol=5.0)
        assert len(np.unique(found.draws[1][found.left[1]])) == 1
        # An event beyond the profile has no coordinate of its own: its end is an elevation.
        assert observed_records(observations)[0] == pytest.approx(profile_end(observations)[0])
        assert observed_records(observations)[1] == observations.observed[1]


def test_only_what_would_be_seen() -> None:
    records = slopes(n_paths=1, n_each=20)
    posterior, mode = fitted(records)
    u = np.repeat(mode.u[None, :], 5, axis=0)
    free = predict_stops(fitted_model(posterior, u, {}), 16000, np.random.default_rng(3))
    limit = float(np.quantile(free.elevation[0], 0.8))
    hidden = replace(records, paths=(replace(records.paths[0], observed_below_m=limit),))
    limited, _ = fitted(hidden)
    found = expected_records(fitted_model(limited, u, {}), 4000, np.random.default_rng(3))
    # What stops below the limit keeps its shape, and is recorded with its error.
    below = free.elevation[0][free.elevation[0] <= limit]
    error = np.random.default_rng(4).normal(0.0, found.sigma[0], len(below))
    recorded = below + error
    assert np.mean(recorded > limit) > 0.01
    assert np.mean(found.draws[0] > limit) == pytest.approx(np.mean(recorded > limit), abs=0.01)
    for q in (0.1, 0.5, 0.9):
        assert np.quantile(found.draws[0], q) == pytest.approx(np.quantile(recorded, q), abs=12.0)


def test_too_few_seen_are_drawn_again() -> None:
    records = slopes(n_paths=1, n_each=20)
    posterior, mode = fitted(records)
    u = np.repeat(mode.u[None, :], 5, axis=0)
    stops = predict_stops(fitted_model(posterior, u, {}), 4000, np.random.default_rng(4))
    limit = float(np.quantile(stops.elevation[0], 0.05))
    hidden = replace(records, paths=(replace(records.paths[0], observed_below_m=limit),))
    limited, _ = fitted(hidden)
    found = expected_records(fitted_model(limited, u, {}), 1000, np.random.default_rng(4))
    assert found.draws.shape == (20, 1000)
    # Records of stops below the limit lie above it by their error alone.
    assert 0.0 < np.max(found.draws[0] - limit) < 5.0 * found.sigma[0]


def test_a_limit_that_is_estimated_moves_with_its_draw() -> None:
    posterior, mode = fitted(slopes(n_paths=1, n_each=20), "observation-limit")
    place = posterior.layout.places["observation-limit"].start
    near, far = mode.u.copy(), mode.u.copy()
    near[place], far[place] = posterior.layout.slots[place].low, posterior.layout.slots[place].high
    highest = np.max(posterior.observations.observed)
    rng = np.random.default_rng(5)
    for u, hides in ((near, True), (far, False)):
        found = expected_records(
            fitted_model(posterior, np.repeat(u[None, :], 5, axis=0), {}), 2000, rng
        )
        assert (np.max(found.draws) <= highest) == hides


def test_elevations_and_places_point_the_same_way() -> None:
    one, other = slopes(n_paths=1), slopes(n_paths=1, kind="x")
    events = (*one.events, *(replace(e, event_id=f"x{e.event_id}") for e in other.events))
    mixed, _ = fitted(replace(one, events=events))
    np.testing.assert_array_equal(error_sign(mixed.observations), [1.0] * 6 + [-1.0] * 6)
    alone, mode = fitted(other)
    np.testing.assert_array_equal(error_sign(alone.observations), np.ones(6))
    found = expected_records(
        fitted_model(alone, draws_about(mode), {}), 300, np.random.default_rng(6)
    )
    np.testing.assert_allclose(found.error, found.draws.mean(axis=1) - found.observed)


def test_path_offsets_move_the_stops() -> None:
    posterior, mode = fitted(slopes(n_paths=5), "path-effect")
    u = draws_about(mode)
    u = np.clip(u, posterior.layout.low, posterior.layout.high)
    offsets = {f"P{k}": np.full(len(u), 0.0) for k in range(5)}
    offsets["P1"] = np.full(len(u), 0.3)
    found = expected_records(fitted_model(posterior, u, offsets), 500, np.random.default_rng(7))
    assert found.draws[6:12].mean() > found.draws[:6].mean() + 20.0
