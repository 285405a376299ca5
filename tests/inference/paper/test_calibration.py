"""Metropolis-Hastings and Gibbs on the twin."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.model.observations import LEFT, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper import calibration
from avahazard.inference.paper.calibration import (
    FLAT_ON_SIGMA,
    calibrate_paper,
    check_method,
    gibbs,
    prior_by,
    recorded_elevation,
    regression,
)
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Records
from avahazard.records.errors import AvahazardError
from avahazard.workflow.stored import summary
from tests.inference import naive
from tests.inference.reference import reference_regression
from tests.inference.worlds import frictions
from tests.workflow.twin import TRUTH, twin_study
from tests.workflow.worlds import bowl, height, stop_x


def _intervals(found: FittedModel) -> dict[str, tuple[float, float]]:
    result = {}
    for k, name in enumerate(found.chains.names):
        s = summary(found.chains.draws[..., k].ravel(), "")
        result[name] = (s.q05, s.q95)
    return result


def _bowl_study(volumes: list[float | None], mus: list[float], **more):
    events = tuple(
        Event(f"E{k}", "B", runout_x_m=stop_x(mu), volume_m3=v, **more)
        for k, (v, mu) in enumerate(zip(volumes, mus, strict=True))
    )
    return build_observations(bowl(events=events))


def test_gibbs_finds_the_twins_law() -> None:
    found = calibrate_paper(
        twin_study(), Specification(), "gibbs", n_chains=4, n_draws=2000, seed=1
    )
    assert found.chains.diagnostics.converged
    intervals = _intervals(found)
    for name, value in TRUTH.items():
        assert intervals[name][0] < value < intervals[name][1]
    assert found.n_events + sum(found.left_out.values()) == 173
    assert "beyond the profile" in found.notes[0]


def test_metropolis_finds_the_law_of_the_mean_stop() -> None:
    # Friction scatters, the stop is not linear in it, and this method scatters the stop about
    # F(μ(V)): what it looks for is the law whose stops are the means of the twin's.
    observations = twin_study()
    stops = predict_records(observations, (), {}).elevation
    volume = np.exp(observations.columns.log_volume)

    def stop(i: int, mu: np.ndarray) -> np.ndarray:
        return np.interp(mu, MU, stops[i])

    noise = np.exp(TRUTH["sigma"] * np.random.default_rng(0).standard_normal(2000))
    means = np.array(
        [stop(i, TRUTH["a"] * np.exp(-TRUTH["n"] * v) * noise).mean() for i, v in enumerate(volume)]
    )

    def squares(u: np.ndarray) -> float:
        mu = u[0] * np.exp(-u[1] * 1e-7 * volume)
        return float(sum((means[i] - stop(i, mu[i])) ** 2 for i in range(len(mu))))

    a, n = minimize(squares, [0.519, 3.36], method="Nelder-Mead").x

    found = calibrate_paper(
        observations, Specification(), "metropolis", n_chains=4, n_draws=5000, seed=1
    )
    assert found.chains.diagnostics.converged
    intervals = _intervals(found)
    for sought in ({"a": a, "n": n * 1e-7}, TRUTH):
        assert intervals["a"][0] < sought["a"] < intervals["a"][1]
        assert intervals["n"][0] < sought["n"] < intervals["n"][1]
    assert found.chains.units[-1] == "m"
    assert found.n_events == int(np.sum(observations.kind != LEFT)) < 173


@pytest.mark.parametrize("law", ["exponential", "power", "rational", "constant"])
def test_coordinates_are_those_of_the_draws(law: str) -> None:
    observations = twin_study("scey", "saugy")
    specification = Specification(law=law)  # type: ignore[arg-type]
    found = calibrate_paper(
        observations, specification, "metropolis", n_chains=2, n_draws=100, seed=3
    )
    chosen = LAWS[law]
    slots = [slot.name for slot in found.posterior.layout.slots]
    assert slots == [*chosen.coordinates, "log sigma"]
    drawn, u = found.chains.pooled(), found.draws
    np.testing.assert_allclose(chosen.to_natural(u[:, :-1]), drawn[:, :-1], rtol=1e-12)
    np.testing.assert_allclose(np.exp(u[:, -1]), drawn[:, -1], rtol=1e-12)
    assert found.sigma_m is not None
    np.testing.assert_allclose(found.sigma_m, drawn[:, -1], rtol=1e-12)


def test_a_place_counts_as_the_elevation_there() -> None:
    observations = _bowl_study([1e4, 1e4, 1e4], [0.45, 0.5, 0.55])
    expected = [float(height(stop_x(mu))) for mu in (0.45, 0.5, 0.55)]
    np.testing.assert_allclose(recorded_elevation(observations), expected, atol=1.0)
    left = replace(observations, kind=np.array([1, 3, 2]))
    assert np.isnan(recorded_elevation(left)).tolist() == [False, True, True]


@pytest.mark.parametrize("method", ["metropolis", "gibbs"])
def test_events_without_a_volume_are_left_out_but_by_the_constant_law(method) -> None:
    observations = _bowl_study([1e4, None, 1e5, 2e4, 5e4], [0.45, 0.5, 0.55, 0.47, 0.53])
    run = {"method": method, "n_chains": 2, "n_draws": 100, "seed": 0}
    found = calibrate_paper(observations, Specification(), **run)
    assert (found.n_events, found.left_out) == (4, {"without a volume": 1})
    found = calibrate_paper(observations, Specification(law="constant"), **run)
    assert (found.n_events, found.left_out, found.notes) == (5, {}, ())


def test_gibbs_takes_events_without_a_profile_and_metropolis_does_not() -> None:
    rng = np.random.default_rng(0)
    events = tuple(
        Event(f"E{k}", fall_height_m=500.0, runout_length_m=500.0 / mu, volume_m3=1e4)
        for k, mu in enumerate(0.4 * np.exp(0.1 * rng.standard_normal(400)))
    )
    observations = build_observations(Records(events=events))
    law = Specification(law="constant")
    found = calibrate_paper(observations, law, "gibbs", n_chains=2, n_draws=1000, seed=0)
    mu = 500.0 / observations.observed
    assert found.chains.draws[..., 0].mean() == pytest.approx(np.exp(np.log(mu).mean()), rel=1e-3)
    assert found.chains.draws[..., 1].mean() == pytest.approx(np.log(mu).std(), rel=0.02)
    with pytest.raises(AvahazardError, match=r"0 of 400 events.*400 without a profile") as error:
        calibrate_paper(observations, law, "metropolis", n_chains=2, n_draws=100, seed=0)
    assert "--method marginal" in error.value.hint


def test_records_that_fit_exactly_leave_no_scatter() -> None:
    observations = _bowl_study([1e4] * 3, [0.45] * 3)
    # At the profile's very end lies the stop of every block that would run on.
    end = replace(observations, observed=np.full(3, observations.sites[0].smooth.x_max))
    with pytest.raises(AvahazardError, match="no scatter"):
        calibrate_paper(
            end, Specification(law="constant"), "metropolis", n_chains=2, n_draws=100, seed=0
        )


@pytest.mark.parametrize(
    ("method", "asked", "word"),
    [
        ("gibbs", {"scatter": "volume"}, "scatter"),
        ("metropolis", {"distribution": "normal"}, "normal friction"),
        ("gibbs", {"tails": "student"}, "Student"),
        ("metropolis", {"effects": ("season", "path-effect")}, "season, path-effect"),
        ("gibbs", {"law": "rational"}, "rational"),
    ],
)
def test_what_a_method_cannot_do(method, asked, word: str) -> None:
    with pytest.raises(AvahazardError, match=word) as error:
        check_method(method, Specification(**asked))
    assert "--method marginal" in error.value.hint
    check_method("marginal", Specification(**asked))


def test_metropolis_can_do_the_rational_law() -> None:
    check_method("metropolis", Specification(law="rational", centrifugal=False))


def test_posterior_equals_quadrature_on_a_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Priors that pull, so that the carried-over prior of the centred level is tried too."""
    volume, mu = frictions("exponential", [0.52, 3e-6], 0.16, 25, 1)
    prior_mean, prior_sd, sigma_prior = np.array([-0.5, 1.0]), np.array([0.05, 0.6]), (2.0, 0.08)
    monkeypatch.setattr(calibration, "WEAK_ON_SIGMA", sigma_prior)
    chosen = replace(law("exponential"), prior_mean=prior_mean, prior_sd=prior_sd)
    result = gibbs(chosen, volume, mu, seed=2, n_draws=40000)
    a, n, sigma = result.pooled().T
    ours = np.stack([np.log(a), n * 1e6, sigma])
    axes = [np.linspace(v.mean() - 6 * v.std(), v.mean() + 6 * v.std(), 90) for v in ours[:2]]
    axes.append(np.linspace(0.06, 0.5, 120))

    def log_density(log_a, n, sigma):
        log_p = naive.log_normal_prior(log_a, prior_mean[0], prior_sd[0])
        log_p = log_p + naive.log_normal_prior(n, prior_mean[1], prior_sd[1])
        log_p = log_p + naive.log_inverse_gamma(sigma, *sigma_prior)
        for v, m in zip(volume, mu, strict=True):
            log_p = log_p + naive.log_normal_prior(np.log(m), log_a - n * v * 1e-6, sigma)
        return log_p

    mean, sd = naive.posterior_on_grid(log_density, axes)
    np.testing.assert_allclose(ours.mean(axis=1), mean, rtol=0.01)
    np.testing.assert_allclose(ours.std(axis=1), sd, rtol=0.03)
    assert result.diagnostics.converged


@pytest.mark.parametrize("name", ["kilpisjarvi", "mesquite"])
def test_reference_draws_of_a_regression(name: str, shared_data: Path) -> None:
    x, y, mean, sd, reference = reference_regression(shared_data, name)
    ours = regression(x, y, prior_by(mean, sd, FLAT_ON_SIGMA), 3, 4, 20000).reshape(-1, 3)
    np.testing.assert_array_less(
        np.abs(ours.mean(axis=0) - reference[:, 0]), 0.05 * reference[:, 1]
    )
    np.testing.assert_allclose(ours.std(axis=0), reference[:, 1], rtol=0.03)


@pytest.mark.parametrize(
    ("name", "natural"),
    [("exponential", [0.519, 3.36e-7]), ("power", [1.07, 0.065]), ("constant", [0.5])],
)
def test_linear_laws_are_recovered(name: str, natural: list[float]) -> None:
    result = gibbs(law(name), *frictions(name, natural, 0.158, 173, 7), seed=1)
    low, high = np.quantile(result.pooled(), [0.001, 0.999], axis=0)
    truth = np.array([*natural, 0.158])
    assert result.names == (*law(name).names, "sigma")
    assert np.all((low < truth) & (truth < high))
    assert result.diagnostics.converged


def test_the_seed_decides() -> None:
    data = frictions("power", [1.0, 0.06], 0.1, 30, 1)
    one = gibbs(law("power"), *data, seed=5, n_draws=50).draws
    np.testing.assert_array_equal(one, gibbs(law("power"), *data, seed=5, n_draws=50).draws)
    assert not np.array_equal(one, gibbs(law("power"), *data, seed=6, n_draws=50).draws)
