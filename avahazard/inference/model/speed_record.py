"""Speeds measured along one track, and how an uneven friction would make them differ.

The friction μ of an avalanche is the mean along its track, which is what its stop asks for. On the
way it goes up and down by ε(x), with standard deviation s and alike over `FRICTION_CORRELATION_M`.
Energy takes up its work: the square of speed differs from that of the block by

    r(x) = -2 g ∫ (ε - mean of ε) dx,

over horizontal distance from the release, where it is 0, to the stop, where it is 0 again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.constants import GRAVITY

FRICTION_CORRELATION_M = 100.0
"""Length over which friction stays alike along a track: about that of a terrain step."""


@dataclass(frozen=True, slots=True, eq=False)
class SpeedRecord:
    """Speeds measured along one event: `x`, `speed`, `sigma`, each `[n_speeds]`.

    `release_x` (m) is where it started, `stop_x` where it was recorded to stop, or the end of the
    profile that it left; `share` `[n_speeds]` of the way there lies above each place. `spread`
    `[n_speeds, n_speeds]` (m⁴/s⁴) is the covariance of r for s = 1, `root` times itself transposed
    the same.
    """

    event: int
    x: Floats
    speed: Floats
    sigma: Floats
    release_x: float
    stop_x: float
    share: Floats
    spread: Floats
    root: Floats


def speed_record(
    event: int, x: Floats, speed: Floats, sigma: Floats, release_x: float, stop_x: float
) -> SpeedRecord:
    """The record of one event that was released and stopped at these places (m)."""
    length = max(stop_x - release_x, 1.0)
    way = np.maximum(x - release_x, 0.0)
    spread = track_spread(way, length)
    values, vectors = np.linalg.eigh(spread)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return SpeedRecord(event, x, speed, sigma, release_x, stop_x, way / length, spread, root)


def track_spread(way: Floats, length: float) -> Floats:
    """Covariance of r for s = 1 at distances `way` `[n_speeds]` (m) on a track of this length."""
    ends = np.append(way, length)
    covariance = _integrated(ends[:, None], ends)
    # Less the mean along the track: r is 0 at its end.
    tie = np.eye(len(ends))[:-1]
    tie[:, -1] = -way / length
    return np.ascontiguousarray((2.0 * GRAVITY) ** 2 * tie @ covariance @ tie.T)


def _integrated(a: Floats, b: Floats) -> Floats:
    """Covariance of ∫ ε dx up to a and up to b, for s = 1: that of ε is exp(-|Δx| / length)."""
    scale = FRICTION_CORRELATION_M
    rest = 1.0 - np.exp(-a / scale) - np.exp(-b / scale) + np.exp(-np.abs(a - b) / scale)
    return 2.0 * scale * np.minimum(a, b) - scale**2 * rest
