from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.criticism.screening.moments_of_worlds import moments_of
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords, real_world
from avahazard.criticism.screening.record_moments import NOTHING, record_moments
from avahazard.criticism.screening.stop_moments import record_bounds
from avahazard.criticism.screening.tables import (
    LOG_MU,
    SPEED_STRIDE,
    Tables,
    make_tables,
    with_scatter,
)
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT, Observations
from tests.inference import studies
from tests.inference.naive_nodes import speed_log_likelihood

TRACK_SCATTER = 0.05


def setting() -> tuple[Observations, Tables, BootstrapRecords]:
    observations = studies.observations()
    model = studies.posterior(observations)
    tables = make_tables(
        observations, predict_records(observations, (), {}), observations.limit, TRACK_SCATTER
    )
    return observations, tables, real_world(model)


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
