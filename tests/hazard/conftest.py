"""A runout curve with everything in it: left profile, stops, a jump, not released."""

import numpy as np
import pytest

from avahazard.physics.runout_curve import RunoutCurve

JUMPS = {24}


@pytest.fixture
def curve() -> RunoutCurve:
    mu = 0.1 + 0.01 * np.arange(60)
    x = 2500 - 3000 * mu
    x[25:] -= 400  # the block stops before the step or beyond it, never on it
    y = 1000 + (2500 - x) * 0.4
    status = np.zeros(60, dtype=np.int8)
    status[:10], x[:10], y[:10] = 1, np.nan, np.nan
    status[55:], x[55:], y[55:] = 2, 0.0, 2000.0
    return RunoutCurve(x, y, status, mu)
