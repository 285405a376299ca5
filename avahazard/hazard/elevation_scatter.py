"""Stops that scatter by σ metres of elevation about the block's (section 2c of Ancey 2005)."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile

N_PLACES = 4001


def scattered_stops(
    smooth: SmoothProfile,
    release_x: float,
    elevation: Floats,
    sigma: Floats,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, int]:
    """Stops x and elevation (m) at `elevation` + `sigma` z, z ~ N(0, 1), and the number held.

    `elevation` `[n_draws]` of the block's stop is -inf where it left the profile, and stays so;
    `sigma` `[n_draws]` in m. x is the first place of the path that is so low. A stop above the
    release is put there and counted as held; one below the end of the path has left it (+inf,
    -inf); one below a valley floor with a counter-slope behind it lies on the floor.
    """
    x = np.linspace(release_x, smooth.x_max, N_PLACES)
    y = smooth.height(x)
    # The places that are lower than all before them.
    falls = np.concatenate([[True], y[1:] < np.minimum.accumulate(y)[:-1]])
    stop = elevation + sigma * rng.standard_normal(len(elevation))
    held = stop > y[0]
    stop = np.where(held, y[0], stop)
    if not falls[-1]:
        stop = np.where(np.isfinite(elevation), np.maximum(stop, y.min()), stop)
    left = stop < y.min()
    place = np.interp(-stop, -y[falls], x[falls])
    return np.where(left, np.inf, place), np.where(left, -np.inf, stop), int(np.sum(held))
