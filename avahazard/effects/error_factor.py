"""The factor by which stated errors are wrong, on its log."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Parameter

PRIOR_SD = float(np.log(2.0))
"""Errors are stated by judgement; that they are off by two either way is common, by four rare."""
MOST = float(np.log(8.0))
HALF_OCTAVES = tuple(float(k * np.log(2.0) / 2.0) for k in range(-6, 7))
"""Logs of the factors from an eighth to eight."""


def log_factor(high: float = MOST, grid: tuple[float, ...] = ()) -> Parameter:
    """The log of the factor, none of it (0) being what is stated."""
    return Parameter("log_factor", "log of the factor", 0.0, 0.0, PRIOR_SD, -MOST, high, grid)


def factor(values: Floats) -> float:
    """The factor at values `[1]` of its log; 1 to the last bit at 0."""
    return float(np.exp(values[0]))
