"""Apparent friction gives back what made the record, and moved records spread it as F says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.laws import law
from avahazard.inference.model.observations import build_observations
from avahazard.inference.paper.apparent import STATUSES, apparent_friction, back_calculate, perturb
from avahazard.inference.paper.least_squares import fit_law
from avahazard.physics.runout_curve import MU, MU_STEP, RunoutCurve
from avahazard.records.collection import Event, Path, Profile, Records
from tests.workflow.worlds import FRICTIONS, bowl, known_stops, smooth_bowl, stop_x


def _invert(runout, stop_y, status=None):
    stop_y = np.atleast_2d(stop_y)
    status = np.zeros(stop_y.shape) if status is None else np.atleast_2d(status)
    table = np.zeros(len(runout), int)
    return apparent_friction(np.array(runout, float), table, stop_y, _curves(stop_y, status))


def _words(result):
    return [STATUSES[code] for code in result.status]


def _curves(stop_y, status):
    return RunoutCurve(-stop_y, stop_y, status.astype(np.int8))


@settings(deadline=None)  # the first call compiles
@given(st.floats(0.1, 0.7))
def test_round_trip_on_a_rising_table(mu: float) -> None:
    stop_y = 1000 + 800 * MU**1.3
    result = _invert([np.interp(mu, MU, stop_y)], stop_y)
    assert _words(result) == ["unique"]
    assert result.mu[0] == pytest.approx(mu, abs=1e-9)


def test_each_event_takes_its_own_table() -> None:
    stop_y = np.array([1000 + 500 * MU, 400 + 1000 * MU])
    record = np.array([1200.0, 800.0, 1150.0])
    table = np.array([0, 1, 0])
    result = apparent_friction(record, table, stop_y, _curves(stop_y, np.zeros((2, len(MU)))))
    np.testing.assert_allclose(result.mu, [0.4, 0.4, 0.3])


def test_a_record_inside_a_jump_says_so() -> None:
    stop_y = 1000 + 500 * MU + 100 * (MU > 0.401)
    result = _invert([1250.0, 1190.0, 1320.0], stop_y)
    assert _words(result) == ["jump", "unique", "unique"]
    assert result.mu_low[0] == pytest.approx(0.40)
    assert result.mu_high[0] == pytest.approx(0.4025)
    assert result.mu[0] == pytest.approx(0.40125)


def test_several_frictions_say_so() -> None:
    stop_y = np.where((MU > 0.1) & (MU < 0.7), 1000 + 300 * np.sin(8 * MU), np.nan)
    stopped = np.isfinite(stop_y)
    result = _invert([1250.0], stop_y, np.where(stopped, 0, 1))
    slow = MU[:-1][(stop_y[:-1] - 1250) * (stop_y[1:] - 1250) < 0]
    assert slow.size == 2
    assert _words(result) == ["several"]
    assert slow[0] <= result.mu_low[0] <= slow[0] + MU_STEP
    assert slow[1] <= result.mu_high[0] <= slow[1] + MU_STEP


def test_records_off_the_table_give_one_sided_brackets() -> None:
    stop_y = 1000 + 500 * MU
    status = np.where(MU < 0.199, 1, np.where(MU > 0.601, 2, 0))
    result = _invert([1060.0, -np.inf, 1400.0, np.nan, 1100.0], stop_y, status)
    assert _words(result) == ["below", "below", "above", "no-record", "unique"]
    np.testing.assert_allclose(result.mu_high[:2], 0.2)
    assert result.mu_low[2] == pytest.approx(0.6)
    assert np.isnan(result.mu[:4]).all()
    assert result.mu[4] == pytest.approx(0.2)


def test_a_gap_of_blocks_that_left_the_profile_is_a_jump() -> None:
    stop_y = 1000 + 500 * MU
    status = np.where((MU > 0.291) & (MU < 0.349), 1, 0)
    result = _invert([1160.0], stop_y, status)
    assert _words(result) == ["jump"]
    assert (result.mu_low[0], result.mu_high[0]) == pytest.approx((0.29, 0.35))


def test_a_table_without_any_stop() -> None:
    assert _words(_invert([1100.0], 1000 + MU, np.ones(len(MU), int))) == ["below"]


STOP_Y = np.array([400 + 1000 * MU, 200 + 2000 * MU])
CURVES = RunoutCurve(-STOP_Y, STOP_Y, np.zeros(STOP_Y.shape, np.int8))
TABLE = np.array([0, 1, 0, 1] * 5)
VOLUME = np.geomspace(2e3, 3e5, 20)


def _records(sigma: float) -> tuple[np.ndarray, np.ndarray]:
    mu = law("power").friction(np.array([1.07, 0.065]), VOLUME)
    runout = np.array([np.interp(m, MU, STOP_Y[k]) for m, k in zip(mu, TABLE, strict=True)])
    return runout, np.full(20, sigma)


def test_spread_is_the_error_over_the_slope() -> None:
    _, sd = perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=1, n_replicates=4000)
    np.testing.assert_allclose(sd, 15.0 / np.where(TABLE == 0, 1000, 2000), rtol=0.05)


def test_each_replicate_is_the_inverse_of_its_records() -> None:
    runout, sigma = _records(0.0)
    moved, sd = perturb(runout, sigma, TABLE, STOP_Y, CURVES, seed=1, n_replicates=3)
    direct = apparent_friction(runout, TABLE, STOP_Y, CURVES).mu
    np.testing.assert_array_equal(moved, np.tile(direct, (3, 1)))
    np.testing.assert_allclose(sd, 0.0, atol=1e-12)


def test_no_spread_is_given_where_most_moved_records_have_no_friction() -> None:
    runout, sigma = _records(15.0)
    runout[0], runout[1] = -np.inf, STOP_Y[1, 0] - 60.0
    _, sd = perturb(runout, sigma, TABLE, STOP_Y, CURVES, seed=1)
    assert np.isnan(sd[:2]).all()
    assert np.isfinite(sd[2:]).all()


def test_laws_spread_with_the_records() -> None:
    """The sd of a linear fit's parameters, by the same propagation in closed form."""
    moved, _ = perturb(*_records(10.0), TABLE, STOP_Y, CURVES, seed=2)
    fitted = np.array([fit_law(law("power"), VOLUME, mu).parameters for mu in moved])
    mean, sd = fitted.mean(axis=0), fitted.std(axis=0, ddof=1)
    np.testing.assert_allclose(mean, [1.07, 0.065], rtol=0.01)
    alpha, beta = 1.07, 0.065
    mu = alpha * VOLUME**-beta
    jacobian = np.stack([mu / alpha, -mu * np.log(VOLUME)], axis=1)
    propagated = np.linalg.pinv(jacobian) * (10.0 / np.where(TABLE == 0, 1000, 2000))
    np.testing.assert_allclose(sd, np.linalg.norm(propagated, axis=1), rtol=0.15)


def test_the_seed_decides() -> None:
    def run(seed: int) -> np.ndarray:
        return perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=seed)[0]

    np.testing.assert_array_equal(run(4), run(4))
    assert not np.array_equal(run(4), run(5), equal_nan=True)


def test_too_few_replicates_have_no_spread() -> None:
    moved, sd = perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=1, n_replicates=1)
    assert np.isnan(sd).all()
    assert moved[0] == pytest.approx(0.7, abs=0.3)


def _found(records: Records):
    observations = build_observations(records)
    return back_calculate(observations, predict_records(observations, (), {}))


def test_the_friction_of_known_runs_is_given_back() -> None:
    found = _found(bowl(1900.0, known_stops()))
    assert [STATUSES[code] for code in found.status] == ["unique"] * 10
    assert found.mu == pytest.approx([*FRICTIONS, *FRICTIONS], abs=2e-3)


def test_its_spread_is_the_error_of_the_record_over_the_slope_of_f() -> None:
    found = _found(bowl(1900.0, known_stops(runout_sigma_m=5.0)))
    for i, mu in enumerate(FRICTIONS):
        slope = (stop_x(mu + 0.01) - stop_x(mu - 0.01)) / 0.02
        assert found.mu_sd[i] == pytest.approx(5.0 / abs(slope), rel=0.15)


def test_without_a_profile_it_is_h_over_l() -> None:
    straight = Event("s", fall_height_m=500.0, runout_length_m=1400.0, runout_sigma_m=14.0)
    found = _found(bowl(1900.0, (*known_stops()[:2], straight)))
    assert found.mu[2] == 500.0 / 1400.0
    assert found.mu_low[2] == found.mu_high[2] == found.mu[2]
    assert found.mu_sd[2] == pytest.approx(0.01 * found.mu[2], rel=0.15)
    alone = _found(Records(events=(straight,)))
    assert alone.mu == found.mu[2]


def test_records_that_bound_friction_from_one_side() -> None:
    left = Event("left", "B", left_profile=True)
    short = Event("short", "B", runout_x_m=-5.0)
    found = _found(bowl(1000.0, (left, short)))
    assert [STATUSES[code] for code in found.status] == ["below", "above"]
    assert np.isnan(found.mu).all()
    assert np.isnan(found.mu_sd).all()
    # The block of this friction just reaches x = 1000 m (of a bowl regularised a little otherwise).
    assert stop_x(found.mu_high[0]) == pytest.approx(1000.0, abs=30.0)
    # Nothing is released where the slope is less than μ.
    steepness = -float(smooth_bowl(1000.0).derivatives(np.zeros(1))[1][0])
    assert steepness <= found.mu_high[1] <= steepness + 0.0025


def test_where_no_friction_stops_the_block_the_one_that_held_it_bounds() -> None:
    # A plane: the block runs off it, or does not start.
    x = np.linspace(0.0, 500.0, 21)
    plane = Records(
        (Path("B"),), (Profile("B", x, 500.0 - 0.6 * x),), (Event("a", "B", runout_x_m=490.0),)
    )
    found = _found(plane)
    assert STATUSES[found.status[0]] == "below"
    assert found.mu_high[0] == pytest.approx(0.6, abs=0.01)
