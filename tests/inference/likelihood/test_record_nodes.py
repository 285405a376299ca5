"""Likelihoods of records and edges of sight over friction, against sums in tiny steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.likelihood.quadrature import N_NODES
from avahazard.inference.likelihood.record_nodes import (
    hidden_from,
    record_density_nodes,
    straight_density_nodes,
)
from avahazard.inference.model.observations import ELEVATION
from avahazard.inference.prediction import look_up
from avahazard.physics.runout_curve import MU
from tests.inference import studies

GRID = np.linspace(0.2, 0.9, 15)
RECORD = 300.0 + 900.0 * (GRID - 0.2) ** 1.3
SPEED = -2.0 + 3.0 * GRID
"""Log density of the speeds, which bends the bump a little."""


def mass(  # type: ignore[no-untyped-def]
    record: np.ndarray,
    left: np.ndarray,
    observed: float,
    sigma: float,
    gone: bool = False,
    hidden: float = np.inf,
):
    place, weight, tail = np.zeros(10), np.zeros(10), np.zeros(2)
    log_mass = record_density_nodes(
        record, left, gone, observed, sigma, SPEED, GRID, hidden, 1, 0.05, place, weight, tail
    )
    return log_mass, place, weight


@pytest.mark.parametrize(("observed", "sigma"), [(480.0, 15.0), (700.0, 40.0)])
def test_a_stop(observed: float, sigma: float) -> None:
    log_mass, place, weight = mass(RECORD, np.zeros(15, bool), observed, sigma)
    mu = np.linspace(0.2, 0.9, 400_001)
    z = (np.interp(mu, GRID, RECORD) - observed) / sigma
    density = np.exp(-0.5 * z * z + np.interp(mu, GRID, SPEED)) / (sigma * np.sqrt(2.0 * np.pi))
    total = np.sum(density) * (mu[1] - mu[0])
    assert log_mass == pytest.approx(np.log(total), abs=3e-3)
    assert np.sum(weight) == pytest.approx(1.0)
    middle = np.sum(density * mu) / np.sum(density)
    assert np.sum(weight * place) == pytest.approx(middle, abs=1e-3)


@pytest.mark.parametrize("hidden", [0.33, 0.36, 0.41])
def test_a_stop_of_which_a_part_is_hidden(hidden: float) -> None:
    log_mass, place, weight = mass(RECORD, np.zeros(15, bool), 480.0, 40.0, hidden=hidden)
    mu = np.linspace(0.2, hidden, 400_001)
    z = (np.interp(mu, GRID, RECORD) - 480.0) / 40.0
    density = np.exp(-0.5 * z * z + np.interp(mu, GRID, SPEED)) / (40.0 * np.sqrt(2.0 * np.pi))
    assert log_mass == pytest.approx(np.log(np.sum(density) * (mu[1] - mu[0])), abs=0.03)
    assert np.sum(weight * place) == pytest.approx(np.average(mu, weights=density), abs=1e-3)
    assert np.max(place[weight > 0.0]) < hidden


def test_what_left_has_the_frictions_that_let_it() -> None:
    left = GRID < 0.5
    log_mass, place, _ = mass(np.where(left, np.nan, RECORD), left, np.nan, 10.0, gone=True)
    mu = np.linspace(0.2, 0.9, 400_001)
    edge = 0.5 * (GRID[left][-1] + GRID[~left][0])
    total = np.sum(np.exp(np.interp(mu, GRID, SPEED))[mu < edge]) * (mu[1] - mu[0])
    assert log_mass == pytest.approx(np.log(total), abs=3e-3)
    assert np.max(place) < edge


def test_a_record_out_of_reach_is_held_by_the_nearest_friction() -> None:
    log_mass, place, weight = mass(RECORD, np.zeros(15, bool), 2000.0, 10.0)
    assert log_mass < -1000.0
    assert np.isfinite(log_mass)
    assert place[np.argmax(weight)] == pytest.approx(GRID[-2])
    _, place, weight = mass(RECORD, np.zeros(15, bool), 2000.0, 10.0, hidden=0.62)
    assert place[np.argmax(weight)] == pytest.approx(0.6)


NONE = np.zeros(15, bool)


@pytest.mark.parametrize(
    ("record", "left", "observed", "gone", "hidden", "ends"),
    [
        # So vague that both ends of the grid count.
        (RECORD, NONE, 700.0, False, np.inf, (True, True)),
        # Beyond a detection limit there is no record.
        (RECORD, NONE, 700.0, False, 0.85, (True, False)),
        # What left says nothing of a stop, nor a stop of what left.
        (RECORD, GRID < 0.3, 700.0, False, np.inf, (False, True)),
        (np.where(GRID < 0.5, np.nan, RECORD), GRID < 0.5, np.nan, True, np.inf, (True, False)),
        # Far from one end.
        (RECORD, NONE, 300.0, False, np.inf, (True, False)),
    ],
)
def test_what_the_ends_of_the_grid_have_beyond_them(  # type: ignore[no-untyped-def]
    record, left, observed, gone, hidden, ends
) -> None:
    sigma = 80.0 if observed == 300.0 else 400.0
    place, weight, tail = np.zeros(10), np.zeros(10), np.zeros(2)
    told = record, left, gone, observed, sigma, SPEED, GRID, hidden, 1, 0.05
    log_mass = record_density_nodes(*told, place, weight, tail)
    for j, counts, share in zip((0, -1), ends, tail, strict=True):
        density = np.exp(SPEED[j])
        if not gone:
            z = (record[j] - observed) / sigma
            density *= np.exp(-0.5 * z * z) / (sigma * np.sqrt(2.0 * np.pi))
        assert share == (pytest.approx(density / np.exp(log_mass)) if counts else 0.0)


def test_the_first_of_frictions_that_are_as_near_holds_what_no_friction_reaches() -> None:
    flat = np.full(15, 300.0)
    log_mass, place, _ = mass(flat, NONE, 2000.0, 10.0)
    z = (300.0 - 2000.0) / 10.0
    # The speeds ask for more friction: the last friction but one.
    assert place[0] == pytest.approx(GRID[-2])
    expected = -0.5 * z * z + SPEED[-2] - np.log(10.0 * np.sqrt(2.0 * np.pi)) + np.log(0.05)
    assert log_mass == pytest.approx(expected)


def test_what_left_may_have_frictions_that_come_and_go() -> None:
    left = (GRID > 0.37) & (GRID < 0.63)
    log_mass, place, weight = mass(np.where(left, np.nan, RECORD), left, np.nan, 10.0, gone=True)
    low, high = GRID[left][0] - 0.025, GRID[left][-1] + 0.025
    mu = np.linspace(low, high, 400_001)
    density = np.exp(np.interp(mu, GRID, SPEED))
    assert log_mass == pytest.approx(np.log(np.sum(density) * (mu[1] - mu[0])), abs=3e-3)
    assert np.sum(weight * place) == pytest.approx(np.average(mu, weights=density), abs=2e-3)
    assert low < np.min(place[weight > 0.0]) < np.max(place[weight > 0.0]) < high


CASES = [
    (754.0, 11065.0, 10.0),
    (100.0, 50_000.0, 10.0),  # H/L = 0.002, off any table made for snow
    (800.0, 300.0, 10.0),  # H/L = 2.7
    (640.0, 1450.0, 200.0),
    (640.0, 1450.0, 700.0),
]


@pytest.mark.parametrize(("height", "length", "sigma"), CASES)
@pytest.mark.parametrize("in_log", [True, False])
@pytest.mark.parametrize("away", [0.0, 0.5])
def test_any_friction_is_told(
    height: float, length: float, sigma: float, in_log: bool, away: float
) -> None:
    """Σ w p(ν) is ∫ p(L | μ) p(ν) dν for a law that scatters about H/L, or off it."""
    place, weight = np.zeros(N_NODES), np.zeros(N_NODES)
    tail = np.zeros(2)
    log_scale, _ = straight_density_nodes(height, length, sigma, in_log, 1, place, weight, tail)
    mu = height / length * np.exp(away)
    centre, scatter = (np.log(mu), 0.3) if in_log else (mu, 0.3 * mu)
    found = np.exp(log_scale) * np.sum(weight * norm.pdf(place, centre, scatter))

    def integrand(along: float) -> float:
        nu = np.log(height / along)
        here, per = (nu, 1.0 / along) if in_log else (height / along, height / along**2)
        return float(norm.pdf(length, along, sigma) * norm.pdf(here, centre, scatter) * per)

    low = max(length - 9 * sigma, 1.0)
    expected = quad(integrand, low, length + 9 * sigma, epsabs=0, limit=500, points=[length])[0]
    assert found == pytest.approx(expected, rel=0.02 if sigma > 500 else 2e-3)


@pytest.mark.parametrize(("height", "length", "sigma"), CASES)
def test_beyond_all_frictions_a_block_goes_nowhere(
    height: float, length: float, sigma: float
) -> None:
    place, weight, tail = np.zeros(N_NODES), np.zeros(N_NODES), np.full(2, np.nan)
    log_scale, _ = straight_density_nodes(height, length, sigma, True, 1, place, weight, tail)
    assert tail[0] == 0.0
    # The density of this record for a length of zero.
    share = norm.pdf(length, 0.0, sigma) / np.exp(log_scale)
    assert tail[1] == (pytest.approx(share) if share > 1e-9 else 0.0)
    assert (tail[1] > 0.0) == (length < 6.0 * sigma)


@pytest.mark.parametrize("jump_m", [0.0, 400.0])
def test_stops_below_the_edge_are_seen_and_those_above_are_not(jump_m: float) -> None:
    observations = studies.observations(speeds=False)
    predicted = predict_records(observations, (), {})
    i = int(np.flatnonzero(observations.kind == ELEVATION)[0])
    # From some friction on blocks stop much higher.
    after = np.arange(len(MU)) > np.searchsorted(-predicted.x[i], -900.0)
    x, elevation = predicted.x.copy(), predicted.elevation.copy()
    x[i, after] -= jump_m
    elevation[i, after] += 0.5 * jump_m
    predicted = replace(predicted, x=x, elevation=elevation)
    j = int(np.flatnonzero(after)[0])
    limits = observations.limit.copy()
    limits[i] = 0.9 * elevation[i, j - 1] + 0.1 * elevation[i, j]
    observations = replace(observations, limit=limits)
    edge = hidden_from(observations, predicted, in_log=False)[i]
    assert MU[j - 1] < edge < MU[j]
    assert predicted.curve[i].discontinuous[j - 1] == bool(jump_m)
    for friction, seen in ((edge - 1e-5, True), (edge + 1e-5, False)):
        stop = look_up(predicted, np.full((observations.n_events, 1), friction))[2][i, 0]
        assert (stop <= limits[i]) == seen
