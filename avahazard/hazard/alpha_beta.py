"""The α-β runout: extreme runout by regression on the terrain alone, a baseline for any model.

β is the angle of the line from the release to the β-point, where the path flattens to 10°; the
extreme runout lies on the line at α = slope β + intercept, with the scatter of the regression.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isnan
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.kernels import kernel
from avahazard.physics.smooth_profile import SmoothProfile

BETA_SLOPE_DEG = 10.0
FLAT_SLOPE = float(np.tan(np.radians(BETA_SLOPE_DEG)))
SHORTEST_RUNOUT_ZONE_M = 100.0
"""A bench shorter than this is no runout zone: real tracks have many of 30 to 50 m."""
AVAFRAME_STEP_M = 10.0
AVAFRAME_FLAT_M = 30.0
"""Longest step of com2AB, and the flat length below its β-point."""


def lasting_flats(x: Floats, steepness: Floats) -> Floats:
    """Places (m) where the path flattens to 10° for a runout zone's length, from the top down."""
    excess = steepness - FLAT_SLOPE
    flat = excess <= 0.0

    def crossings(j: NDArray[np.intp]) -> Floats:
        share = excess[j] / (excess[j] - excess[j + 1])
        return np.asarray(x[j] + share * (x[j + 1] - x[j]))

    falls = crossings(np.flatnonzero(~flat[:-1] & flat[1:]))
    ends = np.append(crossings(np.flatnonzero(flat[:-1] & ~flat[1:])), np.inf)
    ends = ends[np.searchsorted(ends, falls)]
    return np.asarray(falls[ends - falls >= SHORTEST_RUNOUT_ZONE_M])


Coefficients = tuple[float, float, float, float, float]
"""slope, intercept (°), standard deviation (°), bend (° m), drop (° / m) of a regression."""
Found = tuple[float, float, float, float, float, float]
"""What `on_steps` returns."""


@kernel
def steps_of_points(x: Floats, y: Floats, release_x: float, longest: float) -> tuple[Floats, float]:
    """Elevations (m) at equal steps of `longest` m at most, on straight lines between points.

    x, y `[n_points]` (m), x strictly rising; from `release_x` to the last point. Returns y
    `[n_steps + 1]` and the step (m).
    """
    length = x[-1] - release_x
    # A path of 4000.0000001 m has 400 steps of 10 m.
    n = max(int(np.ceil(length / longest - 1e-9)), 1)
    step = length / n
    at_steps = np.empty(n + 1)
    j = 0
    for k in range(n + 1):
        place = min(release_x + k * step, x[-1])
        while j < len(x) - 2 and x[j + 1] < place:
            j += 1
        share = (place - x[j]) / (x[j + 1] - x[j])
        at_steps[k] = y[j] + share * (y[j + 1] - y[j])
    return at_steps, step


@kernel
def first_flat_step(y: Floats, step: float, flat_slope: float, flat_m: float) -> int:
    """The end of the first flat step of those after a steep one, with all of the `flat_m` below.

    y `[n_steps + 1]` (m). A step is flat if it falls by `flat_slope` (m/m) at most. -1: none is.
    """
    fall = flat_slope * step
    more = int(np.ceil(flat_m / step - 1e-9))
    was_steep = False
    n_flat = 0
    for k in range(1, len(y)):
        if y[k - 1] - y[k] > fall:
            was_steep = True
            n_flat = 0
        elif was_steep:
            n_flat += 1
            if n_flat > more:
                return k - more
    return -1


@kernel
def parabola(y: Floats, step: float) -> tuple[float, float]:
    """Second derivative (1/m) and fall (m) of the parabola of least squares through y `[n + 1]`.

    In t = -1 … 1 even and odd terms stay apart: the sums of t and t³ vanish.
    """
    n = len(y) - 1
    s2 = s4 = y0 = y1 = y2 = 0.0
    for k in range(n + 1):
        t = 2.0 * k / n - 1.0
        above = y[k] - y[0]
        s2 += t * t
        s4 += t * t * t * t
        y0 += above
        y1 += t * above
        y2 += t * t * above
    c2 = (y2 - s2 * y0 / (n + 1)) / (s4 - s2 * s2 / (n + 1)) if n > 1 else 0.0
    c1 = y1 / s2
    low = min(c2 - c1, c2 + c1)
    high = max(c2 - c1, c2 + c1)
    for k in range(n + 1):
        t = 2.0 * k / n - 1.0
        value = (c1 + c2 * t) * t
        low = min(low, value)
        high = max(high, value)
    half = 0.5 * step * n
    return 2.0 * c2 / (half * half), high - low


@kernel
def reach(y: Floats, step: float, beta: float, alpha_deg: float) -> float:
    """Distance (m) from the release to the place of the angle α nearest to the β-point at `beta`.

    Downhill of the β-point where it is seen from the release under a larger angle, else uphill.
    nan past the last step; the end of the first where no place is seen under as large an angle.
    """
    fall = np.tan(np.radians(alpha_deg)) * step
    n = len(y) - 1
    k = min(max(int(np.ceil(beta / step - 1e-9)), 1), n)
    if y[0] - k * fall > y[k]:
        while y[0] - k * fall > y[k]:
            if k == n:
                return np.nan
            k += 1
        k -= 1
    else:
        while y[0] - k * fall <= y[k]:
            if k == 1:
                return step
            k -= 1
    over = y[0] - k * fall - y[k]
    under = y[0] - (k + 1) * fall - y[k + 1]
    return float((k + over / (over - under)) * step)


@kernel
def alpha_and_reaches(
    y: Floats, step: float, beta: float, beta_deg: float, by: Coefficients
) -> tuple[float, float, float, float]:
    """α (°), and distances (m) from the release under α, α + sd and α - sd; nan past the end."""
    slope, intercept_deg, sd_deg, bend, drop = by
    alpha = slope * beta_deg + intercept_deg
    if bend != 0.0 or drop != 0.0:
        second, fall = parabola(y, step)
        alpha += bend * second + drop * fall
    return (
        alpha,
        reach(y, step, beta, alpha),
        reach(y, step, beta, alpha + sd_deg),
        reach(y, step, beta, alpha - sd_deg),
    )


@kernel
def on_steps(y: Floats, step: float, flat_slope: float, flat_m: float, by: Coefficients) -> Found:
    """The β-point at the first flat step, and what follows from it; all nan where there is none.

    Returns its distance (m) from the release and its angle (°), then `alpha_and_reaches`.
    """
    k = first_flat_step(y, step, flat_slope, flat_m)
    if k < 0:
        return np.nan, np.nan, np.nan, np.nan, np.nan, np.nan
    beta = k * step
    beta_deg = np.degrees(np.arctan2(y[0] - y[k], beta))
    alpha, middle, low, high = alpha_and_reaches(y, step, beta, beta_deg, by)
    return beta, beta_deg, alpha, middle, low, high


@kernel
def on_points(
    x: Floats,
    y: Floats,
    release_x: float,
    longest: float,
    flat_slope: float,
    flat_m: float,
    by: Coefficients,
) -> tuple[float, Found]:
    """The elevation of the release (m), and `on_steps` of `steps_of_points`."""
    at_steps, step = steps_of_points(x, y, release_x, longest)
    return at_steps[0], on_steps(at_steps, step, flat_slope, flat_m, by)


Status = Literal["stopped", "left_profile", "no_beta_point"]

STEP_M = 1.0


@dataclass(frozen=True, slots=True)
class Regression:
    """α = `slope` β + `intercept_deg`, with standard deviation `sd_deg`, in degrees.

    With `bend` (degrees times m) and `drop` (degrees per m) also + `bend` y'' + `drop` H0: the
    second derivative and the fall of the parabola fitted to the path from the release on, as
    AvaFrame has it; `first_step` tells that the β-point is AvaFrame's too, of points as they are.
    """

    name: str
    slope: float
    intercept_deg: float
    sd_deg: float
    source: str
    bend: float = 0.0
    drop: float = 0.0
    first_step: bool = False

    @property
    def coefficients(self) -> Coefficients:
        """As the kernels take them."""
        return (self.slope, self.intercept_deg, self.sd_deg, self.bend, self.drop)


REGRESSIONS = (
    Regression(
        "norway",
        0.96,
        -1.4,
        2.3,
        "Bakkehøi, Domaas & Lied (Ann. Glaciol. 4, 1983), 206 paths; "
        "method of Lied & Bakkehøi (J. Glaciol. 26, 1980)",
    ),
    Regression(
        "austria",
        0.946,
        -0.83,
        1.5,
        "Lied, Weiler, Bakkehøi & Hopf (ANENA symposium, Chamonix, 1995), 80 paths",
    ),
)
"""What is asked where nothing else is said."""
AVAFRAME_SOURCE = "AvaFrame, module com2AB (settings com2ABCfg.ini), for the Austrian Alps"
AVAFRAME = (
    Regression("avaframe", 1.05, -2.38, 1.25, AVAFRAME_SOURCE, bend=-3130.0, first_step=True),
    Regression(
        "avaframe-small",
        0.933,
        -5.02,
        2.36,
        f"{AVAFRAME_SOURCE}; small avalanches",
        drop=0.0088,
        first_step=True,
    ),
)
BY_NAME = {regression.name: regression for regression in (*REGRESSIONS, *AVAFRAME)}


@dataclass(frozen=True, slots=True)
class AlphaBeta:
    """What one regression says of a path: angles in degrees, x in m, None where there is none.

    `runout_low_x` is that of α + sd (the shorter runout), `runout_high_x` that of α - sd; each is
    None where its line meets no ground before the profile ends. `further_beta_x` lists the places
    below the β-point where the path flattens to 10° again; `smoothed_beta_x` is AvaFrame's β-point
    on the smoothed path, where `beta_x` is that of its points. `status` is that of the runout
    itself.
    """

    regression: Regression
    status: Status
    release_x: float
    release_y: float
    beta_deg: float | None = None
    beta_x: float | None = None
    alpha_deg: float | None = None
    runout_x: float | None = None
    runout_low_x: float | None = None
    runout_high_x: float | None = None
    further_beta_x: tuple[float, ...] = ()
    smoothed_beta_x: float | None = None


def alpha_beta_runouts(
    x: Floats, y: Floats, smooth: SmoothProfile, release_x: float, by: Sequence[Regression]
) -> tuple[AlphaBeta, ...]:
    """The runouts of a path of points x, y `[n_points]` (m) by these regressions, in their order.

    Ours are of the smoothed path, AvaFrame's of the points as they are, as it takes them.
    """
    found = []
    for regression in by:
        smoothed = alpha_beta(smooth, release_x, regression)
        if regression.first_step:
            of_points = alpha_beta_on_points(x, y, release_x, regression)
            found.append(replace(of_points, smoothed_beta_x=smoothed.beta_x))
        else:
            found.append(smoothed)
    return tuple(found)


def alpha_beta(smooth: SmoothProfile, release_x: float, regression: Regression) -> AlphaBeta:
    """Apply a regression to the smoothed path from its release at `release_x` (m).

    The β-point is the first place below the release from which the smoothed path is no steeper
    than 10° for a runout zone's length of x (or to its end); a release that is itself so flat is
    passed first. A regression with `first_step` has AvaFrame's rule (`alpha_beta_on_points`). The
    runout is where the line at α from the release meets the path, sought from the β-point on:
    downhill where α < β, uphill otherwise.
    """
    if regression.first_step:
        x = _places(smooth, release_x, AVAFRAME_STEP_M)
        y = smooth.height(x)
        found = on_steps(y, x[1] - x[0], FLAT_SLOPE, AVAFRAME_FLAT_M, regression.coefficients)
        return _told(regression, (release_x, float(y[0])), found)
    x = _places(smooth, release_x, STEP_M)
    y, gradient, _ = smooth.derivatives(x)
    places = lasting_flats(x, -gradient)
    if not len(places):
        return AlphaBeta(regression, "no_beta_point", release_x, float(y[0]))
    beta = float(places[0]) - release_x
    beta_deg = float(np.degrees(np.arctan2(y[0] - smooth.height(places[0]), beta)))
    found = alpha_and_reaches(y, x[1] - x[0], beta, beta_deg, regression.coefficients)
    further = tuple(float(place) for place in places[1:])
    return _told(regression, (release_x, float(y[0])), (beta, beta_deg, *found), further)


def alpha_beta_on_points(
    x: Floats, y: Floats, release_x: float, regression: Regression
) -> AlphaBeta:
    """Apply a regression as AvaFrame's com2AB does, on the points as they are.

    x, y `[n_points]` (m), x strictly rising. The path is cut into equal steps of at most 10 m. The
    β-point is the end of the first step after a steep one that falls by 10° at most and below
    which 30 m do so too. A release on flat ground is passed first, for which com2AB asks its user
    for a split point. The runout lies within its step, of which com2AB gives an end.
    """
    top, found = on_points(
        x, y, release_x, AVAFRAME_STEP_M, FLAT_SLOPE, AVAFRAME_FLAT_M, regression.coefficients
    )
    return _told(regression, (release_x, top), found)


def _places(smooth: SmoothProfile, release_x: float, longest: float) -> Floats:
    """Places x (m) at equal steps of at most `longest` m from the release to the path's end."""
    n = max(int(np.ceil((smooth.x_max - release_x) / longest - 1e-9)), 1)
    return np.linspace(release_x, smooth.x_max, n + 1)


def _told(
    regression: Regression,
    release: tuple[float, float],
    found: tuple[float, float, float, float, float, float],
    further: tuple[float, ...] = (),
) -> AlphaBeta:
    """Distances (m) from the release as places, nan as None; `found` is as of `on_steps`."""
    release_x, release_y = release
    beta, beta_deg, alpha_deg, *distances = found
    if isnan(beta):
        return AlphaBeta(regression, "no_beta_point", release_x, release_y)
    runout, low, high = (None if isnan(d) else release_x + d for d in distances)
    status: Status = "left_profile" if runout is None else "stopped"
    beta_x = release_x + beta
    return AlphaBeta(
        regression, status, release_x, release_y, beta_deg, beta_x, alpha_deg,
        runout, low, high, further,
    )  # fmt: skip
