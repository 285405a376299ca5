"""Where in its cell a block stops: the first zero of the cubic w through the cell's ends."""

from __future__ import annotations

import numpy as np

from avahazard.kernels import kernel


@kernel(forceinline=True)
def newton_zero(w0: float, d0: float, w1: float, d1: float) -> float:
    """Zero of the cubic with these end values and slopes that falls from w0 > 0 to w1 ≤ 0.

    Four steps of Newton's method from the chord, without a branch; nan where they have not
    converged.
    """
    c2 = 3.0 * (w1 - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w1 - w0)
    t = w0 / (w0 - w1)
    step = 1.0
    for _ in range(4):
        value = w0 + t * (d0 + t * (c2 + t * c3))
        step = value / (d0 + t * (2.0 * c2 + t * 3.0 * c3))
        t -= step
    return t if (w0 > 0.0) & (abs(step) < 1e-7) & (t >= 0.0) & (t <= 1.0) else np.nan


@kernel
def first_zero(w0: float, d0: float, w1: float, d1: float) -> float:
    """First t in (0, 1] where the cubic with these end values and slopes is ≤ 0; -1 if none.

    A zero at t = 0 itself (the release) is not counted.
    """
    c2 = 3.0 * (w1 - w0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (w1 - w0)
    low, high = 0.0, -1.0
    # The minimum between, where the derivative d0 + 2 c2 t + 3 c3 t² rises through zero.
    discriminant = c2 * c2 - 3.0 * c3 * d0
    if discriminant > 0.0:
        root = np.sqrt(discriminant)
        # The stable form of (-c2 + root) / (3 c3), the root where the derivative rises.
        bottom = -d0 / (c2 + root) if c2 > 0.0 else (root - c2) / (3.0 * c3)
        if 0.0 < bottom < 1.0 and w0 + bottom * (d0 + bottom * (c2 + bottom * c3)) <= 0.0:
            high = bottom
    if high < 0.0:
        if w1 > 0.0:
            return -1.0
        high = 1.0
    if w0 <= 0.0:
        low = 1e-9
    # The chord to the end is a good first guess where w falls through zero.
    t = w0 / (w0 - w1) if w0 > 0.0 and w1 < 0.0 and high == 1.0 else 0.5 * (low + high)
    for _ in range(60):
        value = w0 + t * (d0 + t * (c2 + t * c3))
        if value > 0.0:
            low = t
        else:
            high = t
        slope = d0 + t * (2.0 * c2 + 3.0 * t * c3)
        t_new = t - value / slope
        if not low <= t_new <= high:
            t_new = 0.5 * (low + high)
        if abs(t_new - t) < 1e-10:
            return t_new
        t = t_new
    return t
