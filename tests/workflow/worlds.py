"""A bowl of known shape, and records on it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Event, Path, Profile, Records

SLOPE, BEND = 0.8, 4e-4
"""The bowl is y = 1000 - 0.8 x + 2e-4 x²: lowest at x = 2000, where its radius is 2500 m."""
FRICTIONS = (0.42, 0.48, 0.55, 0.62, 0.7)


def height(x: np.ndarray | float) -> np.ndarray:
    """Elevation of the bowl."""
    return 1000.0 - SLOPE * np.asarray(x) + 0.5 * BEND * np.asarray(x) ** 2


def bowl(length_m: float = 1900.0, events: tuple[Event, ...] = ()) -> Records:
    """Path `B` of this length in x, with its profile."""
    x = np.linspace(0.0, length_m, 96)
    return Records((Path("B"),), (Profile("B", x, height(x)),), events)


def smooth_bowl(length_m: float = 1900.0) -> SmoothProfile:
    """The bowl as it is regularised, a little flatter at its ends."""
    x = np.linspace(0.0, length_m, 96)
    return smooth_profile(x, height(x))


@cache
def _terrain(step: float) -> tuple[list[float], list[float]]:
    """f' and f'' of the regularised bowl every half step."""
    _, slope, bend = smooth_bowl().derivatives(np.arange(0.0, 1900.0, 0.5 * step))
    return slope.tolist(), bend.tolist()


@cache
def stop_x(mu: float, step: float = 0.1) -> float:
    """Where the block stops in the regularised bowl, by midpoint steps of equation 2.3."""
    slopes, bends = _terrain(step)

    def pull(k: int, w: float) -> float:
        slope = slopes[k]
        curvature = bends[k] / (1.0 + slope**2) ** 1.5
        cosine = 1.0 / math.sqrt(1.0 + slope**2)
        normal = 9.81 * cosine + curvature * w
        return 2.0 * (-9.81 * slope * cosine - mu * normal) / cosine

    w, n = 0.0, 0
    while True:
        middle = w + 0.5 * step * pull(2 * n, w)
        after = w + step * pull(2 * n + 1, middle)
        if after <= 0.0:
            return step * (n + w / (w - after))
        w, n = after, n + 1


def known_stops(**given: float) -> tuple[Event, ...]:
    """Events of path `B` with the stops of `FRICTIONS`, first by their places, then elevations."""
    stops = {mu: stop_x(mu) for mu in FRICTIONS}
    by_x = [Event(f"x{mu}", "B", runout_x_m=x, **given) for mu, x in stops.items()]
    by_y = [
        Event(f"y{mu}", "B", runout_elevation_m=float(smooth_bowl().height(x)), **given)
        for mu, x in stops.items()
    ]
    return (*by_x, *by_y)
