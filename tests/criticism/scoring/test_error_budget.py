"""The parts of the error in datasets where each of them is known."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from avahazard.criticism.scoring.error_budget import (
    ErrorBudget,
    _shapley,
    error_budget,
    unexplained,
)
from avahazard.criticism.scoring.scores import expected_records
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import calibrate_model
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Path, Records
from tests.inference.studies import near, posterior, profile

SIGMA_M, VOLUME_SD, SCATTER = 12.0, 0.4, 0.1
A, N = 0.45, 1.0


def straight(n: int, seed: int) -> tuple[Records, np.ndarray]:
    """Events without a profile of friction A exp(-N V/1e6); volumes and runouts have errors.

    With them, what each record would be without scatter and without any error.
    """
    rng = np.random.default_rng(seed)
    log_volume = rng.normal(np.log(1e5), 0.7, n)
    told = np.exp(log_volume + VOLUME_SD * rng.standard_normal(n))
    law = A * np.exp(-N * np.exp(log_volume) * 1e-6)
    mu = law * np.exp(SCATTER * rng.standard_normal(n))
    events = tuple(
        Event(
            f"e{i}",
            fall_height_m=400.0,
            runout_length_m=float(400.0 / mu[i] + SIGMA_M * rng.standard_normal()),
            runout_sigma_m=SIGMA_M,
            volume_m3=float(told[i]),
            volume_rel_sigma=VOLUME_SD,
        )
        for i in range(n)
    )
    return Records(events=events), 400.0 / law


def at(model: Posterior, **values: float) -> np.ndarray:
    named = {"log a": np.log(A), "n in 1e-6/m3": N, "log sigma": np.log(SCATTER)}
    return near(model, **(named | values))


def rms(parts: np.ndarray) -> float:
    return float(np.sqrt(np.mean(parts)))


def test_each_part_is_what_it_is_in_the_world() -> None:
    records, exact = straight(1500, 1)
    model = posterior(build_observations(records))
    u = at(model)
    budget = error_budget(fitted_model(model, u[None], {}), np.random.default_rng(2))
    observed = np.array([e.runout_length_m for e in records.events])
    # Natural scatter, as drawn: the variance of 400/mu at the law's friction.
    natural = exact * np.exp(0.5 * SCATTER**2) * np.sqrt(np.expm1(SCATTER**2))
    assert rms(budget.scatter) == pytest.approx(rms(natural**2), rel=0.1)
    assert rms(budget.record) == SIGMA_M
    told = model.observations.volumes
    middle = 400.0 / (A * np.exp(-N * np.exp(told.mean) * 1e-6))
    assert rms(budget.volume) == pytest.approx(rms((exact - middle) ** 2), rel=0.1)
    assert np.max(budget.parameters) == 0.0
    error = observed - middle * np.exp(0.5 * SCATTER**2)
    assert rms(budget.expected) == pytest.approx(rms(error**2), rel=0.1)
    assert unexplained(error, budget) == 0.0
    wrong = error + 80.0
    assert unexplained(wrong, budget) == pytest.approx(rms(wrong**2 - error**2), rel=0.25)


def test_an_exact_law_without_scatter_reaches_the_floor() -> None:
    rng = np.random.default_rng(5)
    points = profile(0)
    volume = np.exp(rng.normal(10.5, 1.0, 1500))
    told = volume * np.exp(0.3 * rng.standard_normal(1500))
    bare = tuple(
        Event(f"e{i}", "P0", runout_elevation_m=400.0, runout_sigma_m=SIGMA_M, volume_m3=float(v))
        for i, v in enumerate(volume)
    )
    events = Records((Path("P0"),), (points,), bare)
    given = build_observations(events)
    table = posterior(given).nodes.predicted_at(np.empty(0))
    mu = A * np.exp(-1.0 * volume * 1e-6)
    stop = np.array([np.interp(mu[i], MU, table.record[i]) for i in range(len(mu))])
    seen = tuple(
        replace(
            e,
            runout_elevation_m=float(stop[i] + SIGMA_M * rng.standard_normal()),
            volume_m3=float(told[i]),
            volume_rel_sigma=0.3,
        )
        for i, e in enumerate(bare)
    )
    model = posterior(build_observations(replace(events, events=seen)))
    u = near(model, **{"log a": np.log(A), "n in 1e-6/m3": 1.0, "log sigma": -3.7})
    fitted = fitted_model(model, u[None], {})
    budget = error_budget(fitted, np.random.default_rng(0))
    observed = model.observations.observed
    predicted = np.array(
        [
            np.interp(A * np.exp(-np.exp(m) * 1e-6), MU, table.record[i])
            for i, m in enumerate(model.observations.volumes.mean)
        ]
    )
    assert rms(budget.floor**2) == pytest.approx(rms((observed - predicted) ** 2), rel=0.05)
    # The least scatter that a model can have.
    assert rms(budget.scatter) < SIGMA_M


def test_parameters_and_paths_count_and_all_parts_add_up() -> None:
    records, _ = straight(40, 3)
    model = posterior(build_observations(records))
    rng = np.random.default_rng(0)
    u = np.array([at(model) for _ in range(300)])
    sure = error_budget(fitted_model(model, u, {}), np.random.default_rng(1))
    u[:, 0] += 0.05 * rng.standard_normal(300)
    unsure = error_budget(fitted_model(model, u, {}), np.random.default_rng(1))
    length = np.array([e.runout_length_m for e in records.events])
    assert np.all(sure.parameters < 1e-9)
    assert rms(unsure.parameters) == pytest.approx(0.05 * rms(length**2), rel=0.15)
    for part in ("volume", "scatter"):
        assert rms(getattr(unsure, part)) == pytest.approx(rms(getattr(sure, part)), rel=0.1)


def test_parameters_of_a_calibration_count_as_least_squares_has_them() -> None:
    """With exact records log μ is a line in V, whose constants have a covariance in closed form."""
    rng = np.random.default_rng(6)
    n, fall = 80, 400.0
    volume = np.exp(rng.normal(np.log(2e5), 0.8, n))
    log_mu = np.log(A) - N * volume * 1e-6 + SCATTER * rng.standard_normal(n)
    events = tuple(
        Event(
            f"e{i}",
            fall_height_m=fall,
            runout_length_m=float(fall / np.exp(log_mu[i])),
            runout_sigma_m=0.5,
            volume_m3=float(volume[i]),
            volume_rel_sigma=1e-3,
        )
        for i in range(n)
    )
    found = calibrate_model(
        build_observations(Records(events=events)), Specification(), {}, n_chains=2, n_draws=1500
    )
    budget = error_budget(found, np.random.default_rng(7))
    design = np.column_stack([np.ones(n), -volume * 1e-6])
    fit, rest, *_ = np.linalg.lstsq(design, log_mu, rcond=None)
    # The variance of the residuals is not known: the constants are Student's.
    covariance = rest[0] / (n - 4.0) * np.linalg.inv(design.T @ design)
    variance = np.einsum("ij,jk,ik->i", design, covariance, design)
    length = fall / np.exp(design @ fit)
    assert rms(budget.parameters) == pytest.approx(rms(length**2 * variance), rel=0.1)
    natural = length**2 * rest[0] / (n - 2.0)
    assert rms(budget.scatter) == pytest.approx(rms(natural), rel=0.1)


def test_what_left_its_profile_has_no_error_of_its_record() -> None:
    events = (
        Event("in", "P0", runout_elevation_m=400.0, runout_sigma_m=SIGMA_M, volume_m3=1e4),
        Event("left", "P0", left_profile=True, volume_m3=1e4),
    )
    model = posterior(build_observations(Records((Path("P0"),), (profile(0),), events)))
    budget = error_budget(fitted_model(model, near(model)[None], {}), np.random.default_rng(0))
    assert budget.record.tolist() == [SIGMA_M**2, 0.0]


def test_unexplained_is_what_is_left_and_never_under_nought() -> None:
    nine = np.full(4, 9.0)
    budget = ErrorBudget(nine, 0 * nine, 0 * nine, 7.0 + 0 * nine, 0 * nine)
    assert unexplained(np.full(4, 5.0), budget) == 3.0
    assert unexplained(np.full(4, 2.0), budget) == 0.0
    # A mean square of 20 for 16, but of four records that differ as much.
    assert unexplained(np.array([8.0, 0.0, 0.0, 4.0]), budget) == 0.0


def test_shapley_is_the_mean_over_orders() -> None:
    rng = np.random.default_rng(4)
    cost = {key: rng.uniform(0.0, 1.0, 2) for key in np.ndindex(2, 2, 2)}
    cost[0, 0, 0] = np.zeros(2)
    parts = _shapley(cost)
    assert np.sum(parts, axis=0) == pytest.approx(cost[1, 1, 1])
    first = []
    for order in permutations(range(3)):
        ahead = [0, 0, 0]
        for s in order[: order.index(0)]:
            ahead[s] = 1
        first.append(cost[(1, ahead[1], ahead[2])] - cost[(0, ahead[1], ahead[2])])
    assert parts[0] == pytest.approx(np.mean(first, axis=0))


def test_misstated_errors_count_as_they_are() -> None:
    records, _ = straight(60, 9)
    for key, field in (("record-error", "runout_sigma_m"), ("volume-error", "volume_rel_sigma")):
        model = posterior(build_observations(records), key)
        factor = 1.4
        events = tuple(replace(e, **{field: factor * getattr(e, field)}) for e in records.events)
        told = posterior(build_observations(Records(events=events)))
        u = at(model)
        u[model.layout.places[key]] = np.log(factor) / model.layout.slots[-1].scale
        budgets, draws = [], []
        for fitted, coordinates in ((model, u), (told, at(told))):
            whole = fitted_model(fitted, coordinates[None], {})
            budgets.append(error_budget(whole, np.random.default_rng(10)))
            draws.append(expected_records(whole, 50, np.random.default_rng(11)))
        for part in ("record", "volume", "scatter"):
            values = [getattr(b, part) for b in budgets]
            np.testing.assert_allclose(values[0], values[1], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(draws[0].draws, draws[1].draws, rtol=1e-9)
        np.testing.assert_allclose(draws[0].sigma, draws[1].sigma, rtol=1e-9)
