from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.stats import norm

from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords, actual_records
from avahazard.criticism.screening.record_moments import (
    FLATTEST,
    N_POINTS,
    NOTHING,
    WIDTH,
    moments_of,
    record_moments,
    window_of,
    without_window,
)
from avahazard.criticism.screening.speed_points import REACH
from avahazard.criticism.screening.tables import (
    LOG_MU,
    SPEED_STRIDE,
    Tables,
    make_tables,
    record_bounds,
    with_scatter,
)
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT, Observations, build_observations
from avahazard.synth.making import make_world
from tests.inference import studies
from tests.inference.naive_nodes import speed_log_likelihood

TRACK_SCATTER = 0.05


def setting() -> tuple[Observations, Tables, BootstrapRecords]:
    observations = studies.observations()
    model = studies.posterior(observations)
    tables = make_tables(
        observations, predict_records(observations, (), {}), observations.limit, TRACK_SCATTER
    )
    return observations, tables, actual_records(model)


def brute_force(observations: Observations, tables: Tables, i: int) -> tuple[float, float, float]:
    """Mean, variance and log mass of one bump by a sum over very many frictions."""
    left = observations.kind[i] == LEFT
    place = np.arange(max(tables.last_left[i], 0), len(LOG_MU) - 1, 1e-3)
    if left:
        place = np.arange(0.0, tables.last_left[i] + 0.5, 1e-3)
    index = np.arange(len(LOG_MU))
    nu = np.interp(place, index, LOG_MU)
    log_density = np.zeros(len(nu))
    if not left:
        place, nu, log_density = (a[nu < tables.hidden_from[i]] for a in (place, nu, log_density))
        record = np.interp(place, index, tables.record[i])
        log_density = norm.logpdf(observations.observed[i], record, observations.sigma[i])
    row = tables.speeds.row[i]
    if row >= 0:
        measured = observations.speeds[row]
        square = [
            np.interp(place, index[::SPEED_STRIDE], column)
            for column in tables.speeds.square[row, :, : len(measured.x)].T
        ]
        speeds = np.sqrt(np.maximum(np.column_stack(square), 0.0))
        log_density = log_density + speed_log_likelihood(measured, speeds, TRACK_SCATTER)
    top = log_density.max()
    weight = np.exp(log_density - top) * np.gradient(nu)
    mean = float(np.average(nu, weights=weight))
    variance = float(np.average((nu - mean) ** 2, weights=weight))
    return mean, variance, float(np.log(weight.sum()) + top)


def test_bumps_are_the_integral_over_friction() -> None:
    observations, tables, measured = setting()
    found = moments_of(tables, measured)
    told = (observations.kind != LEFT) | (tables.speeds.row >= 0)
    # The six that just do not stop so high, or so low, have record_moments at an end of the table.
    middle = (found.variance > 1e-5) & told
    assert middle.sum() > 30
    for i in np.flatnonzero(middle):
        mean, variance, log_mass = brute_force(observations, tables, i)
        spread = np.sqrt(variance)
        assert abs(found.mean[i] - mean) < 0.05 * spread, i
        assert np.sqrt(found.variance[i]) == pytest.approx(spread, rel=0.05), i
        assert abs(found.log_mass[i] - log_mass) < 0.03, i


def test_an_event_that_left_says_nothing_by_itself() -> None:
    observations, tables, measured = setting()
    found = moments_of(tables, measured)
    silent = (observations.kind == LEFT) & (tables.speeds.row < 0)
    assert silent.any()
    assert np.all(found.variance[silent] == 0.0)
    assert np.all(found.log_mass[silent] == 0.0)


def test_a_record_that_no_friction_explains_costs() -> None:
    observations, tables, measured = setting()
    far = BootstrapRecords(measured.observed.copy(), measured.left, measured.tracks)
    i = int(np.flatnonzero((observations.kind == 0) & (tables.speeds.row < 0))[0])
    costs = []
    for away in (40.0, 80.0):
        far.observed[i] = tables.record[i].max() + away * observations.sigma[i]
        costs.append(float(moments_of(tables, far).log_mass[i]))
    ordinary = float(moments_of(tables, measured).log_mass[i])
    assert costs[1] < costs[0] < ordinary - 500.0


def test_coarser_frictions_give_the_same_bump() -> None:
    observations, tables, measured = setting()
    i = int(np.flatnonzero(observations.kind == 2)[0])
    rows = slice(i, i + 1)
    silent = tables.speeds._replace(row=np.full(1, -1))

    def one(step: int):  # type: ignore[no-untyped-def]
        record = tables.record[rows, ::step].copy()
        return record_moments(
            record,
            record_bounds(record),
            tables.last_left[rows] // step,
            tables.hidden_from[rows],
            tables.about[rows],
            tables.height[rows],
            measured.observed[rows],
            observations.sigma[rows],
            measured.left[rows],
            LOG_MU[::step].copy(),
            silent,
            measured.tracks,
            NOTHING,
        )

    fine, coarse = one(1), one(2)
    assert coarse.mean[0] == pytest.approx(fine.mean[0], abs=2e-3)
    assert coarse.log_mass[0] == pytest.approx(fine.log_mass[0], abs=0.02)


def test_what_is_known_of_another_scatter_along_tracks_is_taken_over() -> None:
    _, tables, measured = setting()
    wider = with_scatter(tables, 2.0 * TRACK_SCATTER)
    assert wider.record is tables.record
    known, fresh = moments_of(tables, measured), moments_of(wider, measured)
    found = moments_of(wider, measured, known)
    for one, other in zip(found, fresh, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.array_equal(found.variance, known.variance)


SMALL_ERROR = 0.02
"""An error so small (m) that a cell has many points."""


def plain(
    record: np.ndarray, first: int, observed: float, sigma: float, hidden_from: float
) -> tuple[float, float, float, int]:
    """Mean, variance, log mass and number of the points, summed one by one."""
    points, masses = [], []
    for j in range(first, len(record) - 1):
        z0, z1 = (record[j] - observed) / sigma, (record[j + 1] - observed) / sigma
        width = LOG_MU[j + 1] - LOG_MU[j]
        seen = min(1.0, (hidden_from - LOG_MU[j]) / width)
        ends = [0.0, seen]
        if z0 != z1:
            ends = np.clip(sorted([(-REACH - z0) / (z1 - z0), (REACH - z0) / (z1 - z0)]), 0.0, seen)
        elif abs(z0) > REACH:
            continue
        if ends[1] <= ends[0]:
            continue
        pieces = int(abs(z1 - z0) * (ends[1] - ends[0])) + 1
        t = ends[0] + (np.arange(pieces) + 0.5) * (ends[1] - ends[0]) / pieces
        points += list(LOG_MU[j] + t * width)
        masses += list(
            np.exp(-0.5 * (z0 + t * (z1 - z0)) ** 2) * width * (ends[1] - ends[0]) / pieces
        )
    mean = float(np.average(points, weights=masses))
    variance = float(np.average((np.array(points) - mean) ** 2, weights=masses))
    log_mass = np.log(np.sum(masses)) - np.log(sigma) - 0.5 * np.log(2.0 * np.pi)
    return mean, variance, float(log_mass), len(points)


@pytest.mark.parametrize("sigma", [None, SMALL_ERROR, 400.0])
def test_moments_are_plain_sums(sigma: float | None) -> None:
    observations = studies.observations()
    tables = make_tables(
        observations, predict_records(observations, (), {}), observations.limit, 0.0
    )
    if sigma is not None:
        tables = replace(tables, sigma=np.full(observations.n_events, sigma))
    found = moments_of(tables, actual_records(studies.posterior(observations)))
    most = 0
    some = (observations.kind != LEFT) & (tables.speeds.row < 0) & np.isnan(tables.height)
    for i in np.flatnonzero(some & (found.variance > 1e-8)):
        first = max(tables.last_left[i], 0)
        record = tables.record[i].astype(float)
        told = observations.observed[i], tables.sigma[i], tables.hidden_from[i]
        mean, variance, log_mass, n = plain(record, first, *told)
        most = max(most, n)
        assert found.mean[i] == pytest.approx(mean, abs=1e-9), i
        assert found.variance[i] == pytest.approx(variance, rel=1e-6, abs=1e-12), i
        assert found.log_mass[i] == pytest.approx(log_mass, abs=1e-9), i
    assert some.sum() > 20
    if sigma == 400.0:
        assert most > N_POINTS


# Inner kernels are called by others alone.
@njit
def _taken_out(mean: float, variance: float, log_mass: float, about: float):  # type: ignore[no-untyped-def]
    return without_window(mean, variance, log_mass, about)


@njit
def _window_of(about: float):  # type: ignore[no-untyped-def]
    return window_of(about)


@pytest.mark.parametrize(("place", "sd"), [(-0.7, 0.003), (-1.4, 0.1), (0.3, 0.6)])
def test_what_the_window_did_to_a_normal_is_undone(place: float, sd: float) -> None:
    about, log_mass = -0.8, -3.2
    precision = sd**-2 + WIDTH**-2
    mean = (place * sd**-2 + about * WIDTH**-2) / precision
    # ∫ N(ν; place, sd²) exp(-(ν - about)² / (2 WIDTH²)) dν
    shared = norm.logpdf(place, about, np.hypot(sd, WIDTH)) + np.log(WIDTH * np.sqrt(2.0 * np.pi))
    found = _taken_out(mean, 1.0 / precision, log_mass + shared, about)
    assert found == pytest.approx((place, sd**2, log_mass), rel=1e-9)


def test_what_says_nothing_stays_finite() -> None:
    mean, variance, _ = _taken_out(-0.6, WIDTH**2, 0.0, -0.8)
    assert variance == pytest.approx(1.0 / FLATTEST)
    assert np.isfinite(mean)


def test_without_a_window_nothing_changes() -> None:
    assert _taken_out(-0.6, 0.2, -1.0, np.nan) == (-0.6, 0.2, -1.0)
    assert _window_of(np.nan) == (0.0, 0.0)


def test_where_a_block_is_held_back_whatever_its_friction_that_is_told() -> None:
    """∫ p(record | ν) N(ν; m, 0.25²) dν by the moments and by a plain sum, under much cohesion."""
    observations = build_observations(make_world(1, 400, 20)[0])
    cohesion = find_definition("cohesion")
    effect = cohesion.build(cohesion.facts(observations.columns, observations.sites))
    predicted = predict_records(observations, (effect,), {"cohesion": np.array([2.2])})
    expected = np.full(observations.n_events, -0.8)
    tables = make_tables(observations, predicted, observations.limit, 0.0, expected)
    anywhere = make_tables(observations, predicted, observations.limit, 0.0)
    records = actual_records(studies.posterior(observations))
    at = -1.4  # what cohesion does is taken from friction
    nu = np.linspace(LOG_MU[0], LOG_MU[-1], 200_001)
    prior = norm.pdf(nu, at, 0.25) * (nu[1] - nu[0])
    near, free = [], []
    one, other = moments_of(tables, records), moments_of(anywhere, records)
    for i in np.flatnonzero((observations.kind != LEFT) & (other.variance > 0.02)):
        reach = nu >= LOG_MU[max(tables.last_left[i], 0)]
        record = np.interp(nu, LOG_MU, tables.record[i])
        density = norm.pdf(observations.observed[i], record, tables.sigma[i])
        exact = np.log(np.sum((density * prior)[reach]))
        for told, some in ((one, near), (other, free)):
            spread = np.sqrt(0.25**2 + told.variance[i])
            some.append(told.log_mass[i] + norm.logpdf(told.mean[i], at, spread) - exact)
    assert len(near) > 50
    assert np.mean(np.abs(near)) < 0.1 * np.mean(np.abs(free))
    assert np.median(np.abs(near)) < 0.03
