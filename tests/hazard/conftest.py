"""A runout curve with everything in it: left profile, stops, a jump, not released."""

import numpy as np
import pytest

from avahazard.physics.runout_curve import MU, RunoutCurve

JUMP = int(np.searchsorted(MU, 0.345))
JUMPS = {JUMP - 1}


@pytest.fixture
def curve() -> RunoutCurve:
    x = 2500 - 3000 * MU
    x[JUMP:] -= 400  # the block stops before the step or beyond it, never on it
    y = 1000 + (2500 - x) * 0.4
    status = np.zeros(len(MU), dtype=np.int8)
    left, held = MU < 0.1949, MU > 0.6451
    status[left], x[left], y[left] = 1, np.nan, np.nan
    status[held], x[held], y[held] = 2, 0.0, 2000.0
    return RunoutCurve(x, y, status)
