"""The α-β runout on elevations at equal steps from the release on, compiled."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel

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
