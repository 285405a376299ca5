"""The α-β runout: extreme runout by regression on the terrain alone, a baseline for any model.

β is the angle of the line from the release to the β-point, where the path flattens to 10°; the
extreme runout lies on the line at α = slope β + intercept, with the scatter of the regression.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.notes import Note
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.terrain import TerrainRunout

BETA_SLOPE_DEG = 10.0
FLAT_SLOPE = float(np.tan(np.radians(BETA_SLOPE_DEG)))
SHORTEST_RUNOUT_ZONE_M = 100.0
"""A bench shorter than this is no runout zone: real tracks have many of 30 to 50 m."""


def persistent_flats(x: Floats, steepness: Floats) -> Floats:
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


STEP_M = 1.0


@dataclass(frozen=True, slots=True)
class Regression:
    """α = `slope` β + `intercept_deg`, with standard deviation `sd_deg`, in degrees."""

    name: str
    slope: float
    intercept_deg: float
    sd_deg: float
    source: str


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


def alpha_beta(
    path_id: str, smooth: SmoothProfile, release_x: float, regression: Regression
) -> TerrainRunout:
    """Apply a regression to the smoothed path from its release at `release_x` (m).

    The β-point is the first place below the release (and below where that is flat) from which the
    smoothed path is no steeper than 10° for a runout zone's length of x (or to its end). The runout
    is where the line at α from the release meets the path, sought from the β-point downhill where α
    < β, uphill otherwise; None where it meets no ground before the profile ends. `notes` lists the
    places below where the path flattens to 10° again.
    """
    n = max(int(np.ceil((smooth.x_max - release_x) / STEP_M - 1e-9)), 1)
    x = np.linspace(release_x, smooth.x_max, n + 1)
    y, gradient, _ = smooth.derivatives(x)
    places = persistent_flats(x, -gradient).tolist()
    beta_x = beta = alpha = runout = low = high = None
    notes: tuple[Note, ...] = (Note("no_beta_point", path_id),)
    if places:
        beta_x, *again = places
        beta = float(np.degrees(np.arctan2(y[0] - smooth.height(beta_x), beta_x - release_x)))
        alpha = regression.slope * beta + regression.intercept_deg
        runout, low, high = (
            _reach(x, y, beta_x, alpha + shift * regression.sd_deg) for shift in (0.0, 1.0, -1.0)
        )
        told = [f"{place:.0f}" for place in again]
        notes = (Note("flattens_again", path_id, places=told),) if told else ()
    status = "stopped" if runout is not None else "left_profile"
    return TerrainRunout(
        path_id=path_id,
        coefficients=regression.name,
        source=regression.source,
        status=status if places else "no_beta_point",
        release_x_m=release_x,
        beta_deg=beta,
        beta_x_m=beta_x,
        alpha_deg=alpha,
        alpha_sd_deg=regression.sd_deg,
        runout_x_m=runout,
        runout_elevation_m=None if runout is None else float(smooth.height(runout)),
        runout_x_low_m=low,
        runout_x_high_m=high,
        notes=notes,
    )


def _reach(x: Floats, y: Floats, beta_x: float, alpha_deg: float) -> float | None:
    """The place (m) nearest to the β-point where the line at α from x[0], y[0] meets the ground.

    None past the end; the end of the first step where no place is seen under as large an angle.
    """
    height = y[0] - np.tan(np.radians(alpha_deg)) * (x - x[0]) - y
    k = max(int(np.searchsorted(x, beta_x)), 1)
    if height[k] > 0.0:
        met = np.flatnonzero(height[k:] <= 0.0)
        if not len(met):
            return None
        k += int(met[0]) - 1
    else:
        over = np.flatnonzero(height[1:k] > 0.0)
        if not len(over):
            return float(x[1])
        k = 1 + int(over[-1])
    share = height[k] / (height[k] - height[k + 1])
    return float(x[k] + share * (x[k + 1] - x[k]))
