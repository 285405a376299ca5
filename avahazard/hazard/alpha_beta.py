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

from avahazard.arrays import Floats
from avahazard.hazard.alpha_beta_kernel import (
    Coefficients,
    alpha_and_reaches,
    on_points,
    on_steps,
)
from avahazard.hazard.beta_point import (
    AVAFRAME_FLAT_M,
    AVAFRAME_STEP_M,
    FLAT_SLOPE,
    lasting_flats,
)
from avahazard.physics.smooth_profile import SmoothProfile

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
