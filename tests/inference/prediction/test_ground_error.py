"""The error of runouts by that of the profile's points."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.ground_error import ground_error
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.synth.integrator import run_track
from avahazard.synth.track import make_track

X = np.arange(0.0, 2600.0, 20.0)
FRICTION = 0.42


def true_height(x: np.ndarray) -> np.ndarray:
    """A path that is steep at its top and flat at its end."""
    return 1100.0 * np.exp(-x / 900.0) + 3.0 * np.sin(x / 120.0)


def model(y: np.ndarray, sigma: float | None) -> FittedModel:
    """A constant friction on these points, with two records on the path and one without."""
    given = None if sigma is None else np.full(len(X), sigma)
    events = (
        Event("by x", "G", runout_x_m=1500.0, runout_sigma_m=10.0, volume_m3=1e4),
        Event("by elevation", "G", runout_elevation_m=210.0, runout_sigma_m=10.0, volume_m3=1e4),
        Event("straight", None, fall_height_m=500.0, runout_length_m=1200.0, volume_m3=1e4),
    )
    profile = Profile("G", X, y, elevation_sigma_m=given)
    observations = build_observations(Records((Path("G"),), (profile,), events))
    posterior = Posterior(observations, Specification(law="constant"), ())
    u = np.array([s.mean if np.isnan(s.neutral) else s.neutral for s in posterior.layout.slots])
    return FittedModel(posterior, np.repeat(u[None], 4, axis=0), {})


def test_it_is_how_far_stops_truly_lie_off() -> None:
    """Against blocks on the true ground by another integrator, over many sets of noisy points."""
    rng = np.random.default_rng(1)
    friction = np.full(3, FRICTION)
    track = make_track(X, true_height(X))
    _, stop, _ = run_track(track, np.zeros(1), np.array([FRICTION]))
    off, sd = [], []
    for _ in range(25):
        noisy = model(true_height(X) + rng.normal(0.0, 4.0, len(X)), 4.0)
        table = noisy.posterior.nodes.predicted_at(noisy.draws[0]).curve[0]
        x, y, _ = table.at(np.array([FRICTION]))
        off.append((x[0] - stop[0], y[0] - float(track.elevation(stop[0]))))
        error = ground_error(noisy, rng, friction, 12)
        sd.append((error.x[0], error.elevation[0]))
    expected = np.sqrt(np.mean(np.square(sd), axis=0))
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(off), axis=0)), expected, rtol=0.5)


def test_exact_points_add_nothing_and_noisy_ones_much() -> None:
    rng = np.random.default_rng(2)
    y = true_height(X)
    friction = np.full(3, FRICTION)
    exact = ground_error(model(y, None), rng, friction)
    noisy = ground_error(model(y, 5.0), rng, friction)
    assert exact.x[0] < 1.0
    assert noisy.x[0] > 5.0 * exact.x[0]
    # Each record is in its own coordinate; without a profile there is no ground.
    np.testing.assert_array_equal(noisy.record, [noisy.x[0], noisy.elevation[1], 0.0])


def test_the_median_friction_is_taken_where_none_is_given() -> None:
    world = model(true_height(X), 3.0)
    median = world.median_friction(np.exp(world.observations.volumes.mean))
    one = ground_error(world, np.random.default_rng(3), n_draws=3)
    two = ground_error(world, np.random.default_rng(3), median, n_draws=3)
    np.testing.assert_array_equal(one.x, two.x)
    assert one.x[0] == pytest.approx(one.x[1])
