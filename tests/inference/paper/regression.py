"""Records of an ordinary regression, whose posterior is known."""

from __future__ import annotations

import numpy as np

from avahazard.inference.paper.calibration import FitRecords


def line_records(x: np.ndarray, y: np.ndarray) -> FitRecords:
    """FitRecords of y = u0 - u1 x."""
    return FitRecords(x, y, np.zeros(x.size, np.int64), np.empty(0), 0.0, 1.0, 0, False)
