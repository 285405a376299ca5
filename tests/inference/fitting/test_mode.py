"""The posterior mode, its curvature, and the units of the coordinates."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from avahazard.inference.fitting import mode as mode_module
from avahazard.inference.fitting.mode import (
    covariance_at,
    find_mode,
    likely_friction,
    log_evidence,
    scores_at,
    start_coordinates,
    units,
)
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Records
from tests.inference.studies import one_path, posterior

N_TRUE = 2e-11


def slides(low: float, high: float, n_true: float, n: int = 150) -> Posterior:
    """Runouts H/μ without a profile, μ = 0.1 exp(-n V), log volumes uniform."""
    rng = np.random.default_rng(5)
    volume = np.exp(rng.uniform(np.log(low), np.log(high), n))
    mu = 0.1 * np.exp(-n_true * volume + 0.3 * rng.standard_normal(n))
    events = tuple(
        Event(
            f"s{i}",
            fall_height_m=500.0,
            runout_length_m=500.0 / float(mu[i]),
            runout_sigma_m=50.0,
            volume_m3=float(volume[i]),
            volume_rel_sigma=0.05,
        )
        for i in range(n)
    )
    return assemble(build_observations(Records(events=events)), Specification(), {})


def test_the_law_is_found_over_seven_decades() -> None:
    posterior = slides(1e4, 1e11, N_TRUE)
    mode = find_mode(posterior)
    natural = posterior.layout.readable(mode.u)
    sd = np.sqrt(np.diag(mode.covariance))
    assert float(natural["a"][0]) == pytest.approx(0.1, rel=0.15)
    assert float(natural["n"][0]) == pytest.approx(N_TRUE, rel=0.15)
    assert 0.0 < sd[1] * 1e-6 < 0.1 * N_TRUE
    found = log_evidence(posterior, mode)
    assert np.isfinite(found.value)
    assert found.error < 0.15


def test_they_are_one_on_paths_of_snow() -> None:
    assert np.array_equal(units(slides(1e4, 1e6, 1e-6)), np.ones(3))
    assert units(slides(1e4, 1e11, N_TRUE))[1] < 1e-3


def _model(*effects: str, **settings: str):
    return posterior(build_observations(one_path(40, seed=2, cut_m=1700.0)), *effects, **settings)


def test_the_mode_is_that_of_a_simplex_search() -> None:
    model = _model()
    mode = find_mode(model)
    slow = minimize(
        lambda u: -model.log_density(u),
        mode.u + 0.2,
        method="Nelder-Mead",
        options={"xatol": 1e-7, "fatol": 1e-9, "maxiter": 5000, "maxfev": 5000},
    )
    sd = np.sqrt(np.diag(mode.covariance))
    assert mode.log_density == pytest.approx(-slow.fun, abs=1e-3)
    assert (mode.u - slow.x) / sd == pytest.approx(np.zeros(3), abs=0.02)


def test_the_covariance_is_the_inverse_of_the_curvature() -> None:
    model = _model()
    mode = find_mode(model)
    steps = 0.3 * np.linalg.cholesky(mode.covariance)
    for k in range(3):
        fall = 2.0 * mode.log_density
        fall -= model.log_density(mode.u + steps[:, k]) + model.log_density(mode.u - steps[:, k])
        assert fall == pytest.approx(0.3**2, rel=0.1)


def test_it_starts_near_the_data() -> None:
    model = _model()
    start = start_coordinates(model)
    mode = find_mode(model)
    sd = np.sqrt(np.diag(mode.covariance))
    assert abs(start[0] - mode.u[0]) < 10 * sd[0]
    assert model.log_density(start) > mode.log_density - 60.0


def test_one_wild_record_does_not_lead_the_start_astray() -> None:
    records = one_path(40, seed=2)
    wild = Event("w", "P0", runout_elevation_m=990.0, volume_m3=5e6, volume_rel_sigma=0.1)
    model = posterior(
        build_observations(type(records)(records.paths, records.profiles, (*records.events, wild)))
    )
    without = find_mode(posterior(build_observations(records)))
    assert find_mode(model).u[0] == pytest.approx(without.u[0], abs=0.3)


def test_a_bound_is_not_passed() -> None:
    model = _model("turbulent-drag", law="constant")
    mode = find_mode(model)
    assert np.all(mode.u >= model.layout.low)
    assert np.all(mode.u <= model.layout.high)
    assert np.all(np.linalg.eigvalsh(mode.covariance) > 0.0)


def test_the_likely_friction_is_the_mean_of_the_record() -> None:
    model = _model()
    friction = likely_friction(model.nodes.at(np.empty(0)), True)
    left = model.nodes.at(np.empty(0)).is_probability
    assert np.all(np.isnan(friction[left]))
    assert np.all((friction[~left] > 0.15) & (friction[~left] < 0.8))


def test_a_density_that_bends_up_against_a_bound_is_an_exponential_there() -> None:
    """As the share of wrong records does: else its width would be that of no curvature at all."""
    bend = np.array([[100.0, -6.0], [-6.0, -30.0]])
    rate = 20.0

    def log_densities(u: np.ndarray) -> np.ndarray:
        return rate * u[:, 1] - 0.5 * np.einsum("ni,ij,nj->n", u, bend, u)

    layout = SimpleNamespace(
        low=np.array([-9.0, -1.0]),
        high=np.array([9.0, 0.0]),
        axes=[],
        slots=(None, None),
        law=SimpleNamespace(uses_volume=False),
        spreads={},
    )
    volumes = SimpleNamespace(known=False)
    model: Any = SimpleNamespace(
        layout=layout, observations=SimpleNamespace(volumes=volumes), log_densities=log_densities
    )
    found = covariance_at(model, np.zeros(2))
    assert found == pytest.approx(np.linalg.inv(bend + np.diag([0.0, rate**2])), rel=0.02)


@pytest.mark.parametrize("bend", [20.0, -400.0])
def test_a_bend_at_a_grid_point_is_not_the_curvature(
    bend: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between grid points the density is a blend: at these its slope jumps."""
    sd, grid = 0.0075, (-1.0, 0.0003, 1.0)
    monkeypatch.setattr(mode_module, "scores_at", lambda *_: np.diag([1.0 / sd, 1.0]))

    def log_densities(u: np.ndarray) -> np.ndarray:
        return -0.5 * (u[:, 0] / sd) ** 2 - 0.5 * u[:, 1] ** 2 + bend * np.abs(u[:, 0] - grid[1])

    layout = SimpleNamespace(
        low=np.array([-1.0, -9.0]),
        high=np.array([1.0, 9.0]),
        axes=[0],
        slots=(SimpleNamespace(sd=np.inf),) * 2,
        law=SimpleNamespace(uses_volume=False),
        spreads={},
    )
    model: Any = SimpleNamespace(
        layout=layout,
        log_densities=log_densities,
        observations=SimpleNamespace(volumes=SimpleNamespace(known=True)),
    )
    found = np.sqrt(np.diag(covariance_at(model, np.zeros(2))))
    # No more than four times the information.
    assert found == pytest.approx([sd, 1.0], rel=0.3 if bend > 0.0 else 0.51)
    # Over a fixed small step the bend would make a valley of the peak, or a needle.
    layout.axes = []
    assert not 0.3 * sd < np.sqrt(covariance_at(model, np.zeros(2))[0, 0]) < 3.0 * sd


def test_a_spread_near_none_is_as_wide_as_the_density_says() -> None:
    """Over a tiny step there is next to no curvature, and nearly no draw would hit."""
    width = 0.04

    def log_densities(u: np.ndarray) -> np.ndarray:
        return -0.5 * u[:, 0] ** 2 - 0.5 * (u[:, 1] / width) ** 4

    layout = SimpleNamespace(
        low=np.array([-9.0, 0.005]),
        high=np.array([9.0, 10.0]),
        axes=[],
        slots=(None, None),
        law=SimpleNamespace(uses_volume=False),
        spreads={"path-effect": 1},
    )
    volumes = SimpleNamespace(known=False)
    model: Any = SimpleNamespace(
        layout=layout, observations=SimpleNamespace(volumes=volumes), log_densities=log_densities
    )
    found = np.sqrt(np.diag(covariance_at(model, np.array([0.0, 0.005]))))
    assert found == pytest.approx([1.0, 0.69 * width], rel=0.2)  # by its integral


def test_a_spread_near_none_does_not_widen_the_law() -> None:
    """Over the long step of the spread the curvature by a law changes, which is no correlation."""
    events = np.column_stack([np.ones(200), np.linspace(9.0, 11.0, 200)]) / 0.1

    def log_densities(u: np.ndarray) -> np.ndarray:
        more = 1.0 + (u[:, 2] / 0.1) ** 2
        squares = np.sum((u[:, :2] @ events.T) ** 2, axis=1)
        return -0.5 * squares / more - 0.5 * (u[:, 2] / 0.1) ** 4

    layout = SimpleNamespace(
        low=np.array([-9.0, -9.0, 0.005]),
        high=np.array([9.0, 9.0, 10.0]),
        axes=[],
        slots=(None, None, None),
        law=SimpleNamespace(uses_volume=False),
        spreads={"path-effect": 2},
    )
    volumes = SimpleNamespace(known=False)
    model: Any = SimpleNamespace(
        layout=layout, observations=SimpleNamespace(volumes=volumes), log_densities=log_densities
    )
    found = covariance_at(model, np.array([0.0, 0.0, 0.005]))
    assert found[:2, :2] == pytest.approx(np.linalg.inv(events.T @ events), rel=0.05)


def test_a_step_of_one_event_is_no_slope() -> None:
    """Events are linear in both coordinates, but for one that has a step besides."""
    slopes = np.random.default_rng(2).standard_normal((30, 2))

    def events(u: np.ndarray, _offsets: None) -> np.ndarray:
        return slopes @ u + np.where(np.arange(30) == 7, 5.0 * (u[0] > 0.001), 0.0)

    slot = SimpleNamespace(neutral=np.nan)
    ranges = np.array([[-9.0] * 2, [9.0] * 2])
    layout = SimpleNamespace(slots=(slot, slot), axes=np.arange(2), ranges=ranges)
    model: Any = SimpleNamespace(
        layout=layout, mode_offsets=lambda _: None, event_log_likelihood=events
    )
    model.pinned = lambda _: model
    found = scores_at(model, np.zeros(2), 0.01 * np.eye(2))
    others = np.arange(30) != 7
    np.testing.assert_allclose(found[others], slopes[others])
    assert found[7, 0] == pytest.approx(np.sqrt(np.sum(slopes[others, 0] ** 2)))
    assert found[7, 1] == pytest.approx(slopes[7, 1])
