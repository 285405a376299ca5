"""Moments of the likelihood of a stop, held against plain sums."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.screening.moments_of_worlds import moments_of
from avahazard.criticism.screening.parametric_bootstrap import real_world
from avahazard.criticism.screening.stop_moments import N_POINTS, REACH
from avahazard.criticism.screening.tables import LOG_MU, make_tables
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT
from tests.inference import studies

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
    found = moments_of(tables, real_world(studies.posterior(observations)))
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
