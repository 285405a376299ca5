"""The error of runouts by that of the profile's points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction import ground_error, look_up
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.synth.dataset import make_track, run_track
from tests.physics.paths import drawn_profile

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
    return fitted_model(posterior, np.repeat(u[None], 4, axis=0), {})


def by_drawing(world: FittedModel, friction: float, n_draws: int) -> np.ndarray:
    """The slow, obvious twin: the same blocks on ground as it might be, given its points."""
    rng = np.random.default_rng(4)
    observations = world.observations
    site = observations.sites[0]
    stops = []
    for _ in range(n_draws):
        drawn = replace(site, smooth=drawn_profile(site.smooth, rng))
        tables = predict_records(replace(observations, sites=(drawn,)), (), {}, 1.0)
        stops.append(look_up(tables, np.full((3, 1), friction))[0][:, 0])
    return np.std(stops, axis=0)


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
        sd.append(ground_error(noisy, friction)[:2])
    expected = np.sqrt(np.mean(np.square(sd), axis=0))
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(off), axis=0)), expected, rtol=0.5)


@pytest.mark.parametrize("friction", [0.36, 0.45, 0.6])
def test_it_is_what_blocks_do_on_drawn_ground(friction: float) -> None:
    rng = np.random.default_rng(5)
    noisy = model(true_height(X) + rng.normal(0.0, 3.0, len(X)), 3.0)
    twin = by_drawing(noisy, friction, 60)
    # The load of curvature is left out, and with it a part of what heights between do.
    np.testing.assert_allclose(ground_error(noisy, np.full(3, friction)), twin, rtol=0.4, atol=1e-6)
    assert twin[0] > 2.0


def test_exact_points_add_nothing_and_noisy_ones_much() -> None:
    friction = np.full(3, FRICTION)
    exact = ground_error(model(true_height(X), None), friction)
    noisy = ground_error(model(true_height(X), 5.0), friction)
    assert exact[0] < 1.0
    assert noisy[0] > 5.0 * exact[0]
    assert noisy[1] > 1.0
    assert noisy[2] == 0.0  # without a profile there is no ground


def test_what_leaves_its_profile_is_at_its_end() -> None:
    """Its x is that of the end, whatever the ground; its elevation is that of the end's ground."""
    noisy = model(true_height(X), 5.0)
    x, elevation, _ = ground_error(noisy, np.full(3, 0.2))
    ground = noisy.observations.sites[0].smooth.posterior
    assert ground is not None
    assert x == 0.0
    assert elevation == pytest.approx(ground.sd(X[-1:])[0], rel=1e-6)


def test_the_median_friction_is_taken_where_none_is_given() -> None:
    world = model(true_height(X), 3.0)
    median = world.median_friction(np.exp(world.observations.volumes.mean))
    np.testing.assert_array_equal(ground_error(world), ground_error(world, median))
