"""The ground as the integrator sees it, and the block on it, by Runge-Kutta steps in x.

The product integrates by another method. Equation 2.3 of Ancey (2005) for w = u², with
dξ = √(1 + y'²) dx:
dw/dx = 2 √(1 + y'²) (g sinθ - μ(u) N - resistances), N = max(0, g cosθ + c κ w).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly, make_smoothing_spline

from avahazard.arrays import Floats
from avahazard.kernels import kernel


@dataclass(slots=True)
class Track:
    """A cubic spline y(x) and the resistance in each cell between two knots.

    `knots_m [n_cells + 1]`, `coef [4, n_cells]` in rising powers of x - knot; cell arrays
    `[n_cells]`. The deceleration in a cell is, with u the speed and N the normal force,
    factor μ(u) N + constant + linear u + quadratic u², in m/s², and
    μ(u) = μ (r + (1 - r) / (1 + u / u0)). N = max(0, g cosθ + centrifugal κ u²).
    """

    knots_m: Floats
    coef: Floats
    forest: NDArray[np.bool_]
    constant: Floats = field(init=False)
    linear: Floats = field(init=False)
    quadratic: Floats = field(init=False)
    factor: Floats = field(init=False)
    centrifugal: float = 1.0
    weakening_r: float = 1.0
    weakening_u0: float = 1.0

    def __post_init__(self) -> None:
        n = len(self.knots_m) - 1
        self.constant, self.linear, self.quadratic = np.zeros(n), np.zeros(n), np.zeros(n)
        self.factor = np.ones(n)

    def elevation(self, x_m: Floats | float) -> Floats:
        """Elevation at x, in metres."""
        i = np.clip(np.searchsorted(self.knots_m, x_m, "right") - 1, 0, len(self.forest) - 1)
        d = x_m - self.knots_m[i]
        c = self.coef[:, i]
        return np.asarray(c[0] + d * (c[1] + d * (c[2] + d * c[3])))

    def slope(self, x_m: Floats | float) -> Floats:
        """-dy/dx at x: the tangent of the slope angle."""
        i = np.clip(np.searchsorted(self.knots_m, x_m, "right") - 1, 0, len(self.forest) - 1)
        d = x_m - self.knots_m[i]
        c = self.coef[:, i]
        return np.asarray(-(c[1] + d * (2.0 * c[2] + d * 3.0 * c[3])))

    def place(self, elevation_m: Floats | float) -> Floats:
        """First x from the top at which the path is down to an elevation (clipped to its ends)."""
        x, y = self.fine()
        lowest_so_far = np.minimum.accumulate(y)
        return np.asarray(np.interp(-np.asarray(elevation_m), -lowest_so_far, x))

    def fine(self, step_m: float = 0.5) -> tuple[Floats, Floats]:
        """Points (x, y) along the path, close enough for straight lines between them."""
        n = max(2, int(np.ceil((self.knots_m[-1] - self.knots_m[0]) / step_m)) + 1)
        x = np.linspace(self.knots_m[0], self.knots_m[-1], n)
        return x, self.elevation(x)

    def middles(self) -> Floats:
        """Elevation in the middle of each cell `[n_cells]`, in metres."""
        return self.elevation(0.5 * (self.knots_m[1:] + self.knots_m[:-1]))

    def split(self, x_m: float) -> None:
        """Put a knot at x, so that a resistance can begin or end there; the terrain is the same."""
        i = int(np.searchsorted(self.knots_m, x_m, "right")) - 1
        d = x_m - self.knots_m[i] if 0 <= i < len(self.forest) else 0.0
        if d == 0.0:
            return
        c0, c1, c2, c3 = self.coef[:, i]
        moved = [
            c0 + d * (c1 + d * (c2 + d * c3)),
            c1 + d * (2 * c2 + d * 3 * c3),
            c2 + 3 * c3 * d,
            c3,
        ]
        self.coef = np.insert(self.coef, i + 1, moved, axis=1)
        self.knots_m = np.insert(self.knots_m, i + 1, x_m)
        self.forest = np.insert(self.forest, i + 1, self.forest[i])
        for name in ("constant", "linear", "quadratic", "factor"):
            cells = getattr(self, name)
            setattr(self, name, np.insert(cells, i + 1, cells[i]))


def make_track(
    x_m: Floats, y_m: Floats, land_cover: Sequence[str] | None = None, smooth_m: float = 0.0
) -> Track:
    """Track through profile points `[n_points]`; a cell has the land cover of its upper point.

    `smooth_m` is the wavelength at which a cubic smoothing spline keeps half the amplitude
    (surveyed points are too rough for a curvature); 0 passes through every point.
    """
    if smooth_m > 0.0:
        spacing = float(np.mean(np.diff(x_m)))
        lam = (smooth_m / (2.0 * np.pi)) ** 4 / spacing
        pieces = PPoly.from_spline(make_smoothing_spline(x_m, y_m, lam=lam).tck)
        kept = np.diff(pieces.x) > 0.0
        coef = pieces.c[::-1, kept]
    else:
        coef = CubicSpline(x_m, y_m, bc_type="natural").c[::-1]
    forest = np.array([cover == "forest" for cover in (land_cover or [""] * len(x_m))][:-1])
    return Track(np.array(x_m, float), np.ascontiguousarray(coef, float), forest)


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
