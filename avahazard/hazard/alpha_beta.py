"""The α-β runout: extreme runout by regression on the terrain alone, a baseline for any model.

β is the angle of the line from the release to the β-point, where the path flattens to 10°; the
extreme runout lies on the line at α = slope β + intercept, with the scatter of the regression.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.beta_point import avaframe_points, first_flat_step, lasting_flats
from avahazard.physics.smooth_profile import SmoothProfile

Status = Literal["stopped", "left_profile", "no_beta_point"]

STEP_M = 1.0


@dataclass(frozen=True, slots=True)
class Regression:
    """α = `slope` β + `intercept_deg`, with standard deviation `sd_deg`, in degrees.

    With `bend` (degrees times m) and `drop` (degrees per m) also + `bend` y'' + `drop` H0: the
    second derivative and the fall of the parabola fitted to the path from the release on, as
    AvaFrame has it; `first_step` tells that the β-point is AvaFrame's too.
    """

    name: str
    slope: float
    intercept_deg: float
    sd_deg: float
    source: str
    bend: float = 0.0
    drop: float = 0.0
    first_step: bool = False


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
    below the β-point where the path flattens to 10° again. `status` is that of the runout itself.
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


def alpha_beta_runouts(
    smooth: SmoothProfile, release_x: float, by: tuple[Regression, ...] = REGRESSIONS
) -> tuple[AlphaBeta, ...]:
    """The runouts of a path by these regressions, in their order."""
    return tuple(alpha_beta(smooth, release_x, regression) for regression in by)


def alpha_beta(smooth: SmoothProfile, release_x: float, regression: Regression) -> AlphaBeta:
    """Apply a regression to the path from its release at `release_x` (m).

    The β-point is the first place below the release from which the smoothed path is no steeper
    than 10° for a runout zone's length of x (or to its end); a release that is itself so flat is
    passed first. A regression with `first_step` has AvaFrame's instead (`beta_point`). The runout
    is where the line at α from the release meets the path, sought from the β-point on: downhill
    where α < β, uphill otherwise.
    """
    n = max(int(np.ceil((smooth.x_max - release_x) / STEP_M)), 1)
    x = np.linspace(release_x, smooth.x_max, n + 1)
    if regression.first_step:
        y = smooth.height(x)
        place = first_flat_step(smooth, release_x)
        places = np.array([] if place is None else [place])
    else:
        y, gradient, _ = smooth.derivatives(x)
        places = lasting_flats(x, -gradient)
    release_y = float(y[0])
    if not len(places):
        return AlphaBeta(regression, "no_beta_point", release_x, release_y)
    beta_x = float(places[0])
    beta_deg = float(_angle(beta_x - release_x, release_y - smooth.height(beta_x)))
    alpha_deg = regression.slope * beta_deg + regression.intercept_deg
    alpha_deg += _of_parabola(smooth, release_x, regression)
    # From the release itself there is no line to a place.
    angle = _angle(x[1:] - release_x, release_y - y[1:])
    runout, low, high = (
        _reach(x[1:], angle, beta_x, alpha_deg + shift * regression.sd_deg)
        for shift in (0.0, 1.0, -1.0)
    )
    return AlphaBeta(
        regression=regression,
        status="left_profile" if runout is None else "stopped",
        release_x=release_x,
        release_y=release_y,
        beta_deg=beta_deg,
        beta_x=beta_x,
        alpha_deg=alpha_deg,
        runout_x=runout,
        runout_low_x=low,
        runout_high_x=high,
        further_beta_x=tuple(float(place) for place in places[1:]),
    )


def _of_parabola(smooth: SmoothProfile, release_x: float, regression: Regression) -> float:
    """Degrees that the bend and the fall of the fitted parabola add to α."""
    if regression.bend == regression.drop == 0.0:
        return 0.0
    x, y = avaframe_points(smooth, release_x)
    # In coordinates of -1 to 1, in which the three terms stay apart.
    half = 0.5 * float(x[-1] - x[0])
    terms = np.vander((x - x[0]) / half - 1.0, 3)
    coefficients = np.linalg.lstsq(terms, y, rcond=None)[0]
    second = 2.0 * float(coefficients[0]) / half**2
    return regression.bend * second + regression.drop * float(np.ptp(terms @ coefficients))


def _angle(along: Floats | float, fall: Floats) -> Floats:
    """Angle (degrees) under which places so far along and below (m) are seen from the release."""
    return np.asarray(np.degrees(np.arctan2(fall, along)))


def _reach(x: Floats, angle: Floats, beta_x: float, alpha_deg: float) -> float | None:
    """Place of the angle α nearest to the β-point; None past the end, the top where none is."""
    beyond = x >= beta_x
    start = int(np.argmax(beyond)) if beyond.any() else len(x) - 1
    if angle[start] > alpha_deg:
        under = np.flatnonzero(angle[start:] <= alpha_deg)
        if not len(under):
            return None
        j = start + int(under[0])
        i = j - 1
    else:
        over = np.flatnonzero(angle[: start + 1] > alpha_deg)
        if not len(over):
            return float(x[0])
        i = int(over[-1])
        j = i + 1
    share = (angle[i] - alpha_deg) / (angle[i] - angle[j])
    return float(x[i] + share * (x[j] - x[i]))
