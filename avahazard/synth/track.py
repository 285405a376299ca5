"""The true terrain of a path, and what resists the block in each of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly, make_smoothing_spline

from avahazard.arrays import Floats


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
