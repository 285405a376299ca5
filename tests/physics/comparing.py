"""One path: the block's stops and speeds against the witness."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.block import NOT_RELEASED, STOPPED, run
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.physics.speed import speeds_along
from tests.physics.paths import cells_of, terrain_of
from tests.physics.witness import pieces, witness


def compare(profile: SmoothProfile, release: float, n_frictions: int = 50) -> None:
    """Run frictions up to where no block moves.

    A stop is compared where both stop and F does not jump between neighbouring frictions. The
    squares of speed agree to 0.2 % or 0.05 m²/s², which is a centimetre of the runout.
    """
    terrain = terrain_of(profile, release)
    cells, start = cells_of(terrain), terrain.node(release)
    steepest = float(np.tan(terrain.theta[start]))
    mu = np.linspace(0.3 * steepest, steepest, n_frictions + 1)[:-1]
    stops = run(cells, np.array([start]), mu)
    assert not (stops.status == NOT_RELEASED).any()
    path = pieces(profile)
    compared, n_speeds = 0, 0
    for k in range(n_frictions):
        near = run(cells, np.array([start]), mu[k] + np.array([-1e-6, 1e-6])).x[0]
        if np.isnan(near).all() and k % 10 == 0:
            assert np.isnan(witness(path, release, mu[k])[0])
        if not abs(near[1] - near[0]) < 0.1:  # a jump, or the block runs beyond the profile
            continue
        stop, x, u = witness(path, release, mu[k])
        compared += 1
        assert stops.status[0, k] == STOPPED
        assert stops.x[0, k] == pytest.approx(stop, abs=0.1), mu[k]
        inner = (u > 1.0) & (x < path.x[-1])
        speeds = speeds_along(cells, start, mu[k : k + 1], x[inner])[0]
        np.testing.assert_allclose(speeds**2, u[inner] ** 2, rtol=2e-3, atol=0.05)
        n_speeds += inner.sum()
    assert compared >= n_frictions // 5
    assert n_speeds > 500
