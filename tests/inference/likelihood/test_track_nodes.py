"""Speeds of tracks: their errors, bounds of cells, and nodes between the tables' frictions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.predicted import Predicted, TrackSpeeds
from avahazard.inference.likelihood.record_nodes import DEPTH, REACH
from avahazard.inference.likelihood.terms import event_terms
from avahazard.inference.likelihood.track_nodes import (
    SPLIT,
    between,
    cell_bounds,
    drawn_speeds,
    speed_log_density,
    squared,
    whitening,
)
from avahazard.inference.model.observations import ELEVATION, LEFT, SpeedRecord
from avahazard.physics.runout_curve import MU
from tests.inference.studies import observations, posterior

SIGMA = np.array([1.0, 0.5, 2.0, 1.5])
SPEED = np.array([9.0, 21.0, 24.0, 12.0])


def track(sigma: np.ndarray = SIGMA) -> SpeedRecord:
    x = np.array([40.0, 90.0, 200.0, 390.0])
    return SpeedRecord(0, x, SPEED, sigma, release_x=20.0, stop_x=420.0)


def dense_error() -> np.ndarray:
    """Variance of (u + e)² - σ², with the u of each place smoothed over those beside it."""
    middle = np.array([15.0, 18.0, 19.0, 18.0])
    return 4.0 * middle**2 * SIGMA**2 + 2.0 * SIGMA**4


def test_a_square_is_without_bias_and_has_its_error() -> None:
    rng = np.random.default_rng(1)
    read = 20.0 + 2.0 * rng.standard_normal(400_000)
    square = read**2 - 4.0
    assert np.mean(square) == pytest.approx(400.0, abs=0.5)
    assert np.std(square) == pytest.approx(np.sqrt(4.0 * 400.0 * 4.0 + 2.0 * 16.0), rel=0.01)
    found, error = squared(SPEED, SIGMA)
    np.testing.assert_allclose(found, SPEED**2 - SIGMA**2)
    np.testing.assert_allclose(error**2, dense_error())


@pytest.mark.parametrize("scatter", [0.0, 0.02, 0.3])
def test_whitened_misfits_give_the_density(scatter: float) -> None:
    one = track()
    measured, whiten, constant = whitening(SPEED, SIGMA, one.spread, scatter)
    square = np.array([100.0, 300.0, 500.0, 250.0])
    found = -0.5 * np.sum((whiten @ (measured - square)) ** 2) - constant
    covariance = scatter**2 * one.spread + np.diag(dense_error())
    law = stats.multivariate_normal(square, covariance)
    jacobian = np.sum(np.log(np.sqrt(dense_error()) / SIGMA))
    expected = law.logpdf(SPEED**2 - SIGMA**2) + jacobian
    assert found == pytest.approx(expected, rel=1e-10)
    rows = speed_log_density(np.vstack([measured, square]), (measured, whiten, constant))
    assert rows == pytest.approx([-constant, expected], rel=1e-10)


def test_exact_friction_leaves_the_errors_of_the_measurement() -> None:
    """Without scatter along the track the density is that of the speeds themselves."""
    speed, sigma = np.full(5, 30.0), np.full(5, 0.3)
    one = SpeedRecord(0, np.linspace(50.0, 250.0, 5), speed, sigma, 0.0, 300.0)
    for off in (-0.5, 0.0, 0.4):
        measured, whiten, constant = whitening(speed, sigma, one.spread, 0.0)
        found = -0.5 * np.sum((whiten @ (measured - (speed + off) ** 2)) ** 2) - constant
        expected = stats.norm.logpdf(speed, speed + off, sigma).sum()
        assert found == pytest.approx(expected, abs=0.4)


def test_drawn_speeds_have_the_spread_of_their_law() -> None:
    one = track()
    true = np.array([500.0, 900.0, 1200.0, 700.0])
    draws = drawn_speeds(
        np.tile(true[:, None], 20_000), one, 0.02, np.random.default_rng(2), arrives=True
    )
    # Means of squares, less the measurement's own.
    square = draws**2 - SIGMA[:, None] ** 2
    np.testing.assert_allclose(square.mean(axis=1), true, rtol=0.01)
    error = 4.0 * true * SIGMA**2 + 2.0 * SIGMA**4
    expected = 0.02**2 * one.spread + np.diag(error)
    scale = np.sqrt(np.diag(expected))
    assert np.max(np.abs(np.cov(square) - expected) / np.outer(scale, scale)) < 0.06


def test_what_arrives_was_moving_on_the_way() -> None:
    quiet = track(np.full(4, 1e-9))
    rng = np.random.default_rng(3)
    impossible = np.tile(np.array([[-20.0], [-30.0], [-10.0], [-5.0]]), 200)
    assert np.all(drawn_speeds(impossible, quiet, 0.1, rng, arrives=True) > 0.0)
    # Beyond the stop of its block an avalanche that may stop anywhere does not move.
    short = np.tile(np.array([[80.0], [90.0], [0.0], [0.0]]), 200)
    found = drawn_speeds(short, quiet, 0.1, rng, arrives=False)
    assert np.all(found[:2] > 0.0)
    assert np.max(np.abs(found[2:])) < 1e-6


ONE_SPEED = (np.array([10.0]), np.eye(1), 0.0)
"""A measured square, the inverse of its error, and a constant, as `whitening` gives them."""
NO_JUMP = (-1, np.empty(1))


def part(speeds: np.ndarray) -> np.ndarray:
    """Speeds `[n, 1]` as a part of a wider table, which is how a record finds them."""
    return np.tile(speeds, 2)[:, :1]


def test_the_bound_of_a_cell_by_hand() -> None:
    ends, record = np.array([-3.0, -1.0, -2.0, -5.0]), np.array([100.0, 200.0, 300.0, 400.0])
    speeds = part(np.sqrt(10.0 - np.sqrt(-2.0 * ends))[:, None])
    left = np.array([True, True, False, False])
    told = (speeds, *NO_JUMP, ONE_SPEED, record, left)
    # Nobody stops in the first cell; the second misses the record by a standard deviation.
    stopped = cell_bounds(*told, False, 350.0, 50.0)
    np.testing.assert_allclose(stopped, [-np.inf, -1.5, -2.0])
    np.testing.assert_allclose(cell_bounds(*told, True, np.nan, 50.0), [-1.0, -1.0, -np.inf])
    # What no cell can explain is looked for in all of them.
    nobody = (speeds, *NO_JUMP, ONE_SPEED, record, np.zeros(4, dtype=np.bool_))
    np.testing.assert_array_equal(cell_bounds(*nobody, True, np.nan, 50.0), 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_no_cell_that_counts_is_passed_over(seed: int) -> None:
    """Speeds are asked for where the record leaves a chance: the rest is below `DEPTH`."""
    rng = np.random.default_rng(seed)
    n = 60
    record, left = np.sort(rng.uniform(0.0, 900.0, n)), np.arange(n) >= 55
    speeds = part(np.sort(rng.uniform(0.0, 8.0, (n, 1)), axis=0)[::-1])
    cell, at_jump = int(rng.integers(n)), np.array([1.5])
    observed, error = float(rng.uniform(0.0, 900.0)), 25.0
    constant = (-30.0, 0.0, 30.0)[seed % 3]  # the density at its highest is exp(-constant)
    told = (*ONE_SPEED[:2], constant)
    found = cell_bounds(speeds, cell, at_jump, told, record, left, False, observed, error)
    square = speeds[:, 0] ** 2
    square[cell] = 1.5
    ends = -0.5 * (10.0 - square) ** 2 - constant
    z = (record - observed) / error
    miss = np.where(z[1:] * z[:-1] > 0.0, np.minimum(abs(z[1:]), abs(z[:-1])), 0.0)
    whole = np.maximum(ends[1:], ends[:-1]) - 0.5 * miss**2
    whole[left[1:] & left[:-1]] = -np.inf
    whole[miss > REACH] = -np.inf  # no points of the likelihood there
    counts = whole > np.max(whole) - DEPTH
    np.testing.assert_allclose(found[counts], whole[counts], rtol=1e-12)
    assert np.all(found[~counts] <= np.max(whole) - DEPTH)


PLACES = np.array([0.9, 0.7])
"""Frictions with which the block only just comes to the places of the speeds."""
LEAVES = 0.42
NOWHERE = np.zeros(2)


def _speed(mu: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(3600.0 * (1.0 - mu[:, None] / PLACES), 0.0))


def _stop(mu: np.ndarray) -> np.ndarray:
    return 1000.0 + 1200.0 * np.clip((mu - 0.2) / 0.8, 0.0, 1.0)


def _fast(*events: tuple[int, float, float]) -> np.ndarray:
    """Log likelihoods by nodes of events with two speeds each, friction being 0.45 e^±0.15.

    Each event is its kind, its friction, and the error of its speeds.
    """
    given = observations(6, 6, False)
    n, x = len(events), np.array([200.0, 600.0])
    stops = [np.nan if kind == LEFT else float(_stop(np.array(mu))) for kind, mu, _ in events]
    measured = [
        SpeedRecord(i, x, _speed(np.array([mu]))[0], np.full(2, sigma), 0.0, 1200.0)
        for i, (_, mu, sigma) in enumerate(events)
    ]
    some = type(given)(
        **{name: getattr(given, name) for name in given.__slots__}
        | {
            "kind": np.array([kind for kind, _, _ in events]),
            "observed": np.array(stops),
            "sigma": np.full(n, 10.0),
            "limit": np.full(n, np.nan),
            "fall_height": np.full(n, np.nan),
            "speeds": tuple(measured),
        }
    )
    table = np.repeat(_stop(MU)[None], n, axis=0)
    left = np.array([(MU < LEAVES) & (kind == LEFT) for kind, _, _ in events]).astype(np.int8)
    of_block = table, table, table, left, n * (TrackSpeeds(_speed(MU), -1, NOWHERE),)
    predicted = Predicted(*of_block, some.sigma, np.zeros(n), np.zeros(n))
    nodes = build_nodes(some, predicted, 0.0)
    one = np.ones((n, 1))
    return event_terms(nodes, np.log(0.45) * one, 0.15 * one, one).value


def _slow(kind: int, true_mu: float, sigma: float) -> float:
    """The same by a sum over very fine frictions, with speeds and stops by their formulas."""
    nu = np.linspace(np.log(0.2), np.log(1.2), 400001)
    mu = np.exp(nu)
    square, error = squared(_speed(np.array([true_mu]))[0], np.full(2, sigma))
    logs = stats.norm.logpdf(square, _speed(mu) ** 2, error).sum(axis=1)
    logs += np.sum(np.log(error / sigma))
    if kind == LEFT:
        logs = np.where(mu < LEAVES - 0.00125, logs, -np.inf)
    else:
        logs = logs + stats.norm.logpdf(float(_stop(np.array(true_mu))), _stop(mu), 10.0)
    logs = logs + stats.norm.logpdf(nu, np.log(0.45), 0.15)
    return float(np.log(np.sum(np.exp(logs - logs.max())) * (nu[1] - nu[0])) + logs.max())


@pytest.mark.parametrize("sigma", [0.1, 0.5, 2.0, 8.0])
@pytest.mark.parametrize("true_mu", [0.3512, 0.45, 0.5237, 0.65])
def test_a_record_with_speeds_has_its_likelihood(true_mu: float, sigma: float) -> None:
    assert _fast((ELEVATION, true_mu, sigma))[0] == pytest.approx(
        _slow(ELEVATION, true_mu, sigma), abs=0.03
    )


@pytest.mark.parametrize("sigma", [0.1, 0.5, 2.0])
def test_one_that_left_has_its_likelihood(sigma: float) -> None:
    assert _fast((LEFT, 0.3512, sigma))[0] == pytest.approx(_slow(LEFT, 0.3512, sigma), abs=0.03)


def test_several_events_are_each_as_by_itself() -> None:
    events = [(ELEVATION, 0.5237, 0.5), (LEFT, 0.3512, 2.0), (ELEVATION, 0.45, 2.0)]
    alone = [_fast(event)[0] for event in events]
    assert _fast(*events) == pytest.approx(alone, abs=1e-9)


def _speeds() -> np.ndarray:
    """Speeds of the table as a part of a wider one, which is how a record finds them."""
    return np.tile(_speed(MU), 2)[:, :2]


def test_between_keeps_the_frictions_of_the_table() -> None:
    bound = np.where((MU[1:] > 0.4) & (MU[1:] < 0.45), 0.0, -1e3)
    track = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE, bound, True)
    assert track.grid[0] < 0.4
    assert track.grid[-1] > 0.45
    assert len(track.grid) < 40 * SPLIT
    inside = MU[(track.grid[0] <= MU) & (track.grid[-1] >= MU)]
    assert np.all(np.isin(inside, track.grid))
    assert np.sqrt(track.square) == pytest.approx(_speed(track.grid), abs=1e-6)
    assert track.record == pytest.approx(_stop(track.grid))
    assert np.all(track.left[track.grid < 0.4174])
    assert not np.any(track.left[track.grid > 0.4226])


@pytest.mark.parametrize("good", [0, 1, len(MU) - 2])
def test_between_goes_to_the_ends_of_the_table(good: int) -> None:
    bound = np.full(len(MU) - 1, -1e3)
    bound[good] = 0.0
    track = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE, bound, True)
    assert track.grid[0] == MU[max(good - 1, 0)]
    assert track.grid[-1] == MU[min(good + 2, len(MU) - 1)]


def test_between_is_even_where_f_jumps() -> None:
    bound = np.where((MU[1:] > 0.4) & (MU[1:] < 0.45), 0.0, -1e3)
    cell = int(np.flatnonzero(MU > 0.42)[0])
    at_jump = np.array([300.0, -40.0])
    track = between(MU, _stop(MU), MU < 0.1, _speeds(), cell, at_jump, bound, False)
    within = (track.grid > MU[cell] - 1e-9) & (track.grid < MU[cell + 1] - 1e-9)
    assert np.all(track.square[within] == at_jump)
    beside = (track.grid < MU[cell] - 1e-9) | (track.grid > MU[cell + 1] - 1e-9)
    assert np.sqrt(track.square[beside]) == pytest.approx(_speed(track.grid[beside]), abs=1e-6)


def test_between_takes_fewer_parts_of_many_cells() -> None:
    few = np.where((MU[1:] > 0.4) & (MU[1:] < 0.41), 0.0, -1e3)
    many = np.zeros(len(MU) - 1)
    fine = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE, few, False).grid
    coarse = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE, many, False).grid
    here = coarse[(coarse > 0.4) & (coarse < 0.41)]
    assert np.max(np.diff(fine)) < np.min(np.diff(here))
    assert len(coarse) < len(fine) + 3 * len(MU)


def test_events_without_speeds_are_untouched() -> None:
    with_speeds, without = posterior(observations()), posterior(observations(speeds=False))
    u = np.array([-0.8, 1.0, -1.9, 1.0])
    silent = np.ones(observations().n_events, bool)
    silent[[m.event for m in observations().speeds]] = False
    assert with_speeds.event_log_likelihood(u)[silent] == pytest.approx(
        without.event_log_likelihood(u[:3])[silent], abs=1e-9
    )
