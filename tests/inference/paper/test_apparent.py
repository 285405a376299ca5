"""The inverse of F gives back what made the record, and says where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avahazard.inference.paper.apparent import apparent_friction
from avahazard.physics.runout_curve import RunoutCurve

MU_MIN, MU_STEP = 0.1, 0.01
MU = MU_MIN + MU_STEP * np.arange(61)


def _invert(runout, stop_y, status=None):
    stop_y = np.atleast_2d(stop_y)
    status = np.zeros(stop_y.shape) if status is None else np.atleast_2d(status)
    table = np.zeros(len(runout), int)
    return apparent_friction(np.array(runout, float), table, stop_y, _curves(stop_y, status))


def _curves(stop_y, status):
    return RunoutCurve(-stop_y, stop_y, status.astype(np.int8), MU)


@settings(deadline=None)  # the first call compiles
@given(st.floats(0.1, 0.7))
def test_round_trip_on_a_rising_table(mu: float) -> None:
    stop_y = 1000 + 800 * MU**1.3
    result = _invert([np.interp(mu, MU, stop_y)], stop_y)
    assert result.labels() == ["unique"]
    assert result.mu[0] == pytest.approx(mu, abs=1e-9)


def test_each_event_takes_its_own_table() -> None:
    stop_y = np.array([1000 + 500 * MU, 400 + 1000 * MU])
    record = np.array([1200.0, 800.0, 1150.0])
    table = np.array([0, 1, 0])
    result = apparent_friction(record, table, stop_y, _curves(stop_y, np.zeros((2, 61))))
    np.testing.assert_allclose(result.mu, [0.4, 0.4, 0.3])


def test_a_record_inside_a_jump_says_so() -> None:
    stop_y = 1000 + 500 * MU + 100 * (MU > 0.405)
    result = _invert([1250.0, 1190.0, 1320.0], stop_y)
    assert result.labels() == ["jump", "unique", "unique"]
    assert result.mu_low[0] == pytest.approx(0.40)
    assert result.mu_high[0] == pytest.approx(0.41)
    assert result.mu[0] == pytest.approx(0.405)


def test_several_frictions_say_so() -> None:
    stop_y = 1000 + 300 * np.sin(8 * MU)
    result = _invert([1250.0], stop_y)
    slow = MU[:-1][(stop_y[:-1] - 1250) * (stop_y[1:] - 1250) < 0]
    assert slow.size == 2
    assert result.labels() == ["several"]
    assert slow[0] <= result.mu_low[0] <= slow[0] + MU_STEP
    assert slow[1] <= result.mu_high[0] <= slow[1] + MU_STEP


def test_records_off_the_table_give_one_sided_brackets() -> None:
    stop_y = 1000 + 500 * MU
    status = np.where(MU < 0.195, 1, np.where(MU > 0.605, 2, 0))
    result = _invert([1060.0, -np.inf, 1400.0, np.nan, 1100.0], stop_y, status)
    assert result.labels() == ["below", "below", "above", "no-record", "unique"]
    np.testing.assert_allclose(result.mu_high[:2], 0.2)
    assert result.mu_low[2] == pytest.approx(0.6)
    assert np.isnan(result.mu[:4]).all()
    assert result.mu[4] == pytest.approx(0.2)


def test_a_gap_of_blocks_that_left_the_profile_is_a_jump() -> None:
    stop_y = 1000 + 500 * MU
    status = np.where((MU > 0.295) & (MU < 0.345), 1, 0)
    result = _invert([1160.0], stop_y, status)
    assert result.labels() == ["jump"]
    assert (result.mu_low[0], result.mu_high[0]) == pytest.approx((0.29, 0.35))


def test_a_table_without_any_stop() -> None:
    assert _invert([1100.0], 1000 + MU, np.ones(61, int)).labels() == ["below"]
