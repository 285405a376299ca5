"""The block on a track, by Runge-Kutta steps in x (the product integrates by another method).

Equation 2.3 of Ancey (2005) for w = u², with dξ = √(1 + y'²) dx:
dw/dx = 2 √(1 + y'²) (g sinθ - μ(u) N - resistances), N = max(0, g cosθ + c κ w).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.synth.track import Track

GRAVITY = 9.81
STOPPED, LEFT_PROFILE, NOT_RELEASED = 0, 1, 2
STEP_M = 1.0


@kernel(fastmath=False)
def _rate(d, w, c, resistance, motion):  # type: ignore[no-untyped-def]
    """dw/dx at the distance d into a cell."""
    slope = c[1] + d * (2.0 * c[2] + d * 3.0 * c[3])
    root = math.sqrt(1.0 + slope * slope)
    curvature = (2.0 * c[2] + 6.0 * c[3] * d) / (root * root * root)
    w = max(w, 0.0)
    u = math.sqrt(w)
    mu, centrifugal, r, u0 = motion
    constant, linear, quadratic, factor = resistance
    normal = max(0.0, GRAVITY / root + centrifugal * curvature * w)
    friction = factor * mu * (r + (1.0 - r) / (1.0 + u / u0)) * normal
    resisting = friction + constant + linear * u + quadratic * w
    return 2.0 * root * (-GRAVITY * slope / root - resisting)


@kernel(fastmath=False)
def _step(d, w, h, c, resistance, motion):  # type: ignore[no-untyped-def]
    """w after one classical Runge-Kutta step of length h."""
    k1 = _rate(d, w, c, resistance, motion)
    k2 = _rate(d + 0.5 * h, w + 0.5 * h * k1, c, resistance, motion)
    k3 = _rate(d + 0.5 * h, w + 0.5 * h * k2, c, resistance, motion)
    k4 = _rate(d + h, w + h * k3, c, resistance, motion)
    return w + h * (k1 + 2.0 * (k2 + k3) + k4) / 6.0


@kernel(fastmath=False)
def _run(knots, coef, cells, x0, motion, step, w_knots):  # type: ignore[no-untyped-def]
    """One run from rest at x0: (status, x of the stop); fills w_knots where it passes."""
    i = min(max(np.searchsorted(knots, x0, "right") - 1, 0), len(knots) - 2)
    x, w = x0, 0.0
    first = (cells[0, i], cells[1, i], cells[2, i], cells[3, i])
    if _rate(x - knots[i], 0.0, coef[i], first, motion) <= 0.0:
        return NOT_RELEASED, x
    while i < len(knots) - 1:
        resistance = (cells[0, i], cells[1, i], cells[2, i], cells[3, i])
        c = coef[i]
        n = max(1, math.ceil((knots[i + 1] - x) / step))
        h = (knots[i + 1] - x) / n
        d = x - knots[i]
        for k in range(n):
            at = d + k * h
            after = _step(at, w, h, c, resistance, motion)
            if after <= 0.0:
                low, high = 0.0, h
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    if _step(at, w, middle, c, resistance, motion) > 0.0:
                        low = middle
                    else:
                        high = middle
                return STOPPED, knots[i] + at + high
            w = after
        i += 1
        x = knots[i]
        w_knots[i] = w
    return LEFT_PROFILE, x


@kernel(fastmath=False)
def _run_all(  # type: ignore[no-untyped-def]
    knots, coef, cells, release, mu, centrifugal, r, u0, step, status, stop, w_knots
):
    for j in range(len(mu)):
        motion = (mu[j], centrifugal, r, u0)
        status[j], stop[j] = _run(knots, coef, cells, release[j], motion, step, w_knots[j])


def run_track(
    track: Track, release_x_m: Floats, mu: Floats, step_m: float = STEP_M
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Run events `[n_events]` down a track.

    Returns the status (STOPPED, LEFT_PROFILE, NOT_RELEASED), x of the stop in metres
    (the end of the profile where it was left, the release where nothing moved), and the
    speed in m/s at every knot `[n_events, n_knots]`, 0 where the block did not pass.
    """
    n = len(mu)
    status, stop = np.zeros(n, np.int64), np.zeros(n)
    w_knots = np.zeros((n, len(track.knots_m)))
    cells = np.stack([track.constant, track.linear, track.quadratic, track.factor])
    _run_all(
        track.knots_m,
        np.ascontiguousarray(track.coef.T),
        cells,
        np.ascontiguousarray(release_x_m, float),
        np.ascontiguousarray(mu, float),
        float(track.centrifugal),
        float(track.weakening_r),
        float(track.weakening_u0),
        step_m,
        status,
        stop,
        w_knots,
    )
    return status, stop, np.sqrt(w_knots)
