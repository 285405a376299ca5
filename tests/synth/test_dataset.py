"""Streams of random numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from avahazard.synth.dataset import (
    LEFT_PROFILE,
    NOT_RELEASED,
    STOPPED,
    Track,
    generator,
    make_track,
    run_track,
)
from avahazard.synth.making import make_sites
from tests.synth.naive import run_in_time


def test_a_stream_depends_on_its_seed_and_key_alone() -> None:
    draws = {
        (seed, key): generator(seed, key).integers(1 << 60)
        for seed in (0, 1)
        for key in ("volumes", "dates")
    }
    assert len(set(draws.values())) == 4
    assert generator(1, "dates").integers(1 << 60) == draws[1, "dates"]


def no_change(_: Track) -> None:
    return


def no_curvature(track: Track) -> None:
    track.centrifugal = 0.0


def weakening(track: Track) -> None:
    track.weakening_r, track.weakening_u0 = 0.8, 10.0


def cohesion(track: Track) -> None:
    track.constant += 0.6


def drag(track: Track) -> None:
    track.quadratic += 0.002


def entrainment(track: Track) -> None:
    above = float(track.elevation(0.3 * track.knots_m[-1]))
    track.split(float(track.place(above)))
    track.quadratic += np.where(track.middles() > above, 0.004, 0.0)


def forest(track: Track) -> None:
    track.quadratic += np.where(track.forest, 0.004, 0.0)


CHANGES = (no_change, no_curvature, weakening, cohesion, drag, entrainment, forest)


# Every change on one of three places, and none on all of them.
@pytest.mark.parametrize(
    ("place", "change"),
    [(0, no_change), (2, no_change), *((k % 3, change) for k, change in enumerate(CHANGES, 1))],
)
def test_stop_is_that_of_an_integration_in_time(
    place: int, change: Callable[[Track], None]
) -> None:
    site = make_sites(11, 3, 30)[place]
    track = make_track(site.profile.x_m, site.profile.y_m, site.profile.land_cover)
    change(track)
    mu, release = np.array([0.46, 0.6]), np.array([40.0, 120.0])
    status, stop, speeds = run_track(track, release, mu)
    assert (status == STOPPED).all()
    for j in range(2):
        x, fastest = run_in_time(track, release[j], mu[j])
        assert stop[j] == pytest.approx(x, abs=0.05)
        assert speeds[j].max() == pytest.approx(fastest, rel=0.005)


def test_without_curvature_friction_is_fall_over_length() -> None:
    x = np.arange(0.0, 2001.0, 10.0)
    y = 1000.0 - 0.9 * x + 0.9 * x**2 / 4500.0
    track = make_track(x, y)
    track.centrifugal = 0.0
    mu = np.array([0.55, 0.65, 0.75])
    status, stop, _ = run_track(track, np.full(3, 50.0), mu)
    assert (status == STOPPED).all()
    fall = track.elevation(50.0) - track.elevation(stop)
    np.testing.assert_allclose(fall / (stop - 50.0), mu, rtol=1e-6)


def test_what_does_not_stop_or_start_says_so() -> None:
    x = np.arange(0.0, 501.0, 10.0)
    track = make_track(x, 1000.0 - 0.5 * x)
    status, stop, speeds = run_track(track, np.array([20.0, 20.0]), np.array([0.4, 0.6]))
    assert status.tolist() == [LEFT_PROFILE, NOT_RELEASED]
    assert stop.tolist() == [500.0, 20.0]
    # A straight slope: u² = 2 g (H - μ L).
    assert speeds[0, -1] == pytest.approx(np.sqrt(2 * 9.81 * (0.5 - 0.4) * 480.0), rel=1e-6)
    assert (speeds[1] == 0.0).all()


X = np.arange(0.0, 1501.0, 15.0)
Y = 1900.0 - 900.0 * (1.0 - np.exp(-X / 700.0)) + 4.0 * np.sin(X / 90.0)


def test_track_is_the_natural_spline_through_its_points() -> None:
    track, spline = make_track(X, Y), CubicSpline(X, Y, bc_type="natural")
    x = np.linspace(0.0, 1500.0, 777)
    np.testing.assert_allclose(track.elevation(x), spline(x), rtol=1e-12)
    np.testing.assert_allclose(track.slope(x), -spline(x, 1), rtol=1e-9, atol=1e-12)


def test_split_changes_nothing_but_the_knots() -> None:
    track, x = make_track(X, Y, ["forest"] * 50 + ["open"] * 51), np.linspace(0.0, 1500.0, 333)
    track.quadratic[20] = 0.5
    before = track.elevation(x), track.slope(x)
    track.split(307.0)
    assert 307.0 in track.knots_m
    np.testing.assert_allclose(track.elevation(x), before[0], rtol=1e-12)
    np.testing.assert_allclose(track.slope(x), before[1], rtol=1e-9)
    assert track.quadratic[19:23].tolist() == [0.0, 0.5, 0.5, 0.0]
    assert track.forest.sum() == 51
    track.split(307.0)
    assert len(track.knots_m) == len(X) + 1


def test_place_is_where_the_elevation_is() -> None:
    track = make_track(X, Y)
    asked = np.array([1850.0, 1500.0, 1200.0])
    np.testing.assert_allclose(track.elevation(track.place(asked)), asked, atol=1e-3)
