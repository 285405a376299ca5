import numpy as np
import pytest

from avahazard.hazard.runout_curve import RunoutCurve, pieces
from tests.hazard.conftest import JUMPS
from tests.hazard.naive import naive_stop


def look_up(curve: RunoutCurve, mu: float) -> tuple[float, float, int]:
    rows, status = pieces(curve)
    t = (mu - curve.mu_min) / curve.mu_step
    k = int(np.clip(2 * t + 1, 0, len(rows) - 1))
    return rows[k, 0] + rows[k, 1] * t, rows[k, 2] + rows[k, 3] * t, int(status[k])


@pytest.mark.parametrize("mu", np.linspace(-0.05, 0.85, 181) + 0.0013)
def test_pieces_equal_the_twin(curve: RunoutCurve, mu: float) -> None:
    x, y, _ = look_up(curve, mu)
    assert (x, y) == pytest.approx(naive_stop(curve, mu, JUMPS), abs=1e-9)


def test_status_is_that_of_the_nearer_node(curve: RunoutCurve) -> None:
    assert look_up(curve, 0.1944)[2] == 1
    assert look_up(curve, 0.1956)[2] == 0
    assert look_up(curve, 0.6444)[2] == 0
    assert look_up(curve, 0.6456)[2] == 2


def test_nothing_stops_on_a_step_that_no_run_stops_on(curve: RunoutCurve) -> None:
    stops = [look_up(curve, mu)[0] for mu in np.linspace(0.33, 0.36, 301)]
    assert not [x for x in stops if curve.stop_x[25] + 1e-9 < x < curve.stop_x[24] - 1e-9]


def test_a_curve_that_steepens_smoothly_is_no_jump() -> None:
    mu = 0.1 + 0.01 * np.arange(40)
    x = 3000 * np.exp(-4 * mu)
    curve = RunoutCurve(0.1, 0.01, x, 2000 - x / 3, np.zeros(40, dtype=np.int8))
    for i in range(39):
        assert look_up(curve, mu[i] + 0.005)[0] == pytest.approx((x[i] + x[i + 1]) / 2)
