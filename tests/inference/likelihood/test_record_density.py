"""The mass of p(record | μ) over friction, against the integral summed in tiny steps."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.record_density import record_density_nodes

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
        # Beyond a limit of sight there is no record.
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
