"""Speeds that tell friction more closely than the tables are spaced."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.block_runs import JumpedStop
from avahazard.inference.likelihood.event_terms import event_terms
from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.speed_errors import squared
from avahazard.inference.likelihood.speed_nodes import SPLIT, between, squares
from avahazard.inference.model.observations import ELEVATION, LEFT, speed_record
from avahazard.physics.runout_curve import MU
from tests.inference.studies import observations, posterior

REACH = np.array([0.9, 0.7])
"""Frictions with which the block only just comes to the places of the speeds."""
LEAVES = 0.42
NOWHERE = JumpedStop(-1, np.zeros(2))


def _speed(mu: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(3600.0 * (1.0 - mu[:, None] / REACH), 0.0))


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
        speed_record(i, x, _speed(np.array([mu]))[0], np.full(2, sigma), 0.0, 1200.0)
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
    of_block = table, table, table, left, n * (_speed(MU),), n * (NOWHERE,)
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
    track = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE.square, bound, True)
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
    track = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE.square, bound, True)
    assert track.grid[0] == MU[max(good - 1, 0)]
    assert track.grid[-1] == MU[min(good + 2, len(MU) - 1)]


def test_between_is_even_where_f_jumps() -> None:
    bound = np.where((MU[1:] > 0.4) & (MU[1:] < 0.45), 0.0, -1e3)
    cell = int(np.flatnonzero(MU > 0.42)[0])
    jumped = np.array([300.0, -40.0])
    track = between(MU, _stop(MU), MU < 0.1, _speeds(), cell, jumped, bound, False)
    within = (track.grid > MU[cell] - 1e-9) & (track.grid < MU[cell + 1] - 1e-9)
    assert np.all(track.square[within] == jumped)
    beside = (track.grid < MU[cell] - 1e-9) | (track.grid > MU[cell + 1] - 1e-9)
    assert np.sqrt(track.square[beside]) == pytest.approx(_speed(track.grid[beside]), abs=1e-6)


def test_between_takes_fewer_parts_of_many_cells() -> None:
    few = np.where((MU[1:] > 0.4) & (MU[1:] < 0.41), 0.0, -1e3)
    many = np.zeros(len(MU) - 1)
    fine = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE.square, few, False).grid
    coarse = between(MU, _stop(MU), MU < LEAVES, _speeds(), -1, NOWHERE.square, many, False).grid
    here = coarse[(coarse > 0.4) & (coarse < 0.41)]
    assert np.max(np.diff(fine)) < np.min(np.diff(here))
    assert len(coarse) < len(fine) + 3 * len(MU)


def test_squares_go_straight_below_nought_where_a_block_stops_short() -> None:
    # u² falls evenly with friction: 9, 5, 1 and, carried on, -3; the last place is never reached.
    speeds = np.sqrt(
        np.array([[16.0, 9.0, 0.0], [12.0, 5.0, 0.0], [8.0, 1.0, 0.0], [4.0, 0.0, 0.0]])
    )
    found = squares(np.vstack([speeds, np.zeros((2, 3))]))
    expected = [
        [16.0, 9.0, 0.0],
        [12.0, 5.0, 0.0],
        [8.0, 1.0, 0.0],
        [4.0, -3.0, 0.0],
        # Just at rest, where it is carried on to nought itself.
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_events_without_speeds_are_untouched() -> None:
    with_speeds, without = posterior(observations()), posterior(observations(speeds=False))
    u = np.array([-0.8, 1.0, -1.9, 1.0])
    silent = np.ones(observations().n_events, bool)
    silent[[m.event for m in observations().speeds]] = False
    assert with_speeds.event_log_likelihood(u)[silent] == pytest.approx(
        without.event_log_likelihood(u[:3])[silent], abs=1e-9
    )
