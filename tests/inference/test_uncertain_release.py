"""Stops from releases that are not known well, against runs of another integrator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction import (
    N_RELEASES,
    from_each_release,
    normal_places,
    predict_stops,
    stops_over_releases,
    told,
)
from avahazard.records.collection import Event, Path, Records
from avahazard.synth.dataset import make_track, run_track
from tests.inference.studies import profile

Z0, SIGMA_Z, MU, SCATTER = 930.0, 40.0, 0.5, 0.015
N, MANY = 3000, 4000
GROUND = profile(0)
ON_PATH = Event("y", "P0", release_elevation_m=Z0)
LINE = Event("s", fall_height_m=400.0, runout_length_m=900.0)


def on(events: Sequence[Event]) -> FittedModel:
    """Friction scatters about a constant, on these events."""
    records = Records((Path("P0"),), (GROUND,), tuple(events))
    made = Posterior(build_observations(records), Specification(law="constant"), ())
    u = np.zeros(len(made.layout.slots))
    u[0], u[made.layout.scatter] = np.log(MU), np.log(SCATTER)
    return fitted_model(made, u[None], {})


def by_hand(sigma_z: float, seed: int) -> np.ndarray:
    """Elevations of stops of blocks that start and rub by chance."""
    rng = np.random.default_rng(seed)
    track = make_track(GROUND.x_m, GROUND.y_m)
    # Over the top of the profile is its top.
    start = np.minimum(rng.normal(Z0, sigma_z, MANY), GROUND.y_m[0])
    friction = MU * np.exp(SCATTER * rng.standard_normal(MANY))
    _, x, _ = run_track(track, track.place(start), friction)
    return np.asarray(track.elevation(x))


def test_it_is_the_spread_of_blocks_that_start_by_chance() -> None:
    sigma = np.array([SIGMA_Z, 200.0])
    rng = np.random.default_rng(1)
    values, left = stops_over_releases(on, [ON_PATH, LINE], sigma, N, rng)
    exact, bare = by_hand(SIGMA_Z, 2), by_hand(0.0, 3)
    # It matters here.
    assert exact.std() > 1.3 * bare.std()
    assert values[0].mean() == pytest.approx(exact.mean(), abs=0.08 * exact.std())
    assert values[0].std() == pytest.approx(exact.std(), rel=0.04)
    shares = [0.05, 0.25, 0.5, 0.75, 0.95]
    away = np.quantile(values[0], shares) - np.quantile(exact, shares)
    assert np.abs(away).max() < 0.15 * exact.std()
    assert not left.any()
    # L = H / μ: both errors are shares of it.
    share = values[1].std() / values[1].mean()
    assert share == pytest.approx(np.hypot(200.0 / 400.0, SCATTER), rel=0.05)


def test_a_release_without_error_changes_nothing() -> None:
    values, _ = stops_over_releases(on, [ON_PATH], np.array([1e-9]), N, np.random.default_rng(1))
    model = on([ON_PATH])
    stops = predict_stops(model, N, np.random.default_rng(4))
    plain = told(model.observations, stops.record, stops.elevation)[0]
    assert values[0].mean() == pytest.approx(plain.mean(), abs=0.08 * plain.std())
    assert values[0].std() == pytest.approx(plain.std(), rel=0.05)


def test_the_releases_are_a_normal() -> None:
    places = normal_places(N_RELEASES)
    assert places.mean() == pytest.approx(0.0, abs=1e-12)
    assert places.std() == pytest.approx(1.0)
    copies = from_each_release(ON_PATH, 5.0, on([ON_PATH]).observations, 0)
    starts = [copy.release_elevation_m for copy in copies]
    np.testing.assert_allclose(starts, Z0 + 5.0 * places, atol=0.01)


def test_a_fall_stays_a_fall() -> None:
    copies = from_each_release(LINE, 1000.0, on([LINE]).observations, 0)
    assert min(copy.fall_height_m or 0.0 for copy in copies) > 0.0
