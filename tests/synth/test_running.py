"""Fronts ahead of the block, and records shifted up the path."""

from __future__ import annotations

import numpy as np

from avahazard.synth.running import ahead, uphill
from avahazard.synth.track import make_track

# Down at 3 in 4 to x = 400 m, then up at the same slope: 5 m of path for 4 m of x.
X = np.arange(0.0, 801.0, 10.0)
TRACK = make_track(X, 1000.0 - 300.0 + 0.75 * np.abs(X - 400.0))


def test_front_is_ahead_along_the_path() -> None:
    stop, lead = np.array([100.0, 380.0, 780.0, 100.0]), np.array([50.0, 50.0, 99.0, 0.0])
    np.testing.assert_allclose(ahead(TRACK, stop, lead), [140.0, 420.0, 800.0, 100.0], atol=1.0)


def test_uphill_is_back_towards_the_release() -> None:
    rise = np.array([30.0, 30.0, 1e4, 0.0])
    found = uphill(TRACK, np.array([200.0, 440.0, 200.0, 123.0]), rise)
    np.testing.assert_allclose(found, [160.0, 360.0, 0.0, 123.0], atol=2.5)
