"""The terrain of a track."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from avahazard.synth.track import make_track

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


@pytest.mark.parametrize(("wavelength", "share"), [(40.0, 0.02), (200.0, 0.5), (1000.0, 1.0)])
def test_smoothing_halves_its_wavelength(wavelength: float, share: float) -> None:
    x = np.arange(0.0, 4001.0, 10.0)
    wave = 3.0 * np.sin(2.0 * np.pi * x / wavelength)
    track = make_track(x, 2000.0 - 0.4 * x + wave, smooth_m=200.0)
    inside = (x > 800.0) & (x < 3200.0)
    left = (track.elevation(x) - 2000.0 + 0.4 * x)[inside]
    assert left @ wave[inside] / (wave[inside] @ wave[inside]) == pytest.approx(share, abs=0.03)
