"""A fitted model, and whether its chains have converged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.fitted_model import diagnose_chains, exact_volumes, fitted_model, in_slots
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.layout import Arms
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.collection import Event, Records
from tests.inference.studies import near, observations, posterior, records


def _draws(given: Posterior, n: int = 50) -> np.ndarray:
    return np.array([near(given, 0.05, seed) for seed in range(n)])


def _new_events(*events: Event) -> Observations:
    known = records(speeds=False)
    return build_observations(Records(known.paths, known.profiles, events), observations())


def test_volumes_as_recorded() -> None:
    given = observations()
    unknown = replace(given.columns, log_volume=given.columns.log_volume.copy())
    unknown.log_volume[3] = np.nan
    volumes = exact_volumes(replace(given, columns=unknown))
    known = np.arange(given.n_events) != 3
    np.testing.assert_array_equal(volumes.log_volume[known, 0], given.columns.log_volume[known])
    np.testing.assert_array_equal(volumes.sd[known], 0.0)
    assert volumes.sd[3] == given.volumes.sd[3] > 0.0
    assert volumes.log_volume[3, 0] == volumes.mean[3] == given.volumes.mean[3]
    np.testing.assert_array_equal(volumes.weight, np.ones((given.n_events, 1)))
    np.testing.assert_array_equal(volumes.volume, np.exp(volumes.log_volume))


def test_draws_go_to_the_slots_of_their_names() -> None:
    """What was fitted without speeds has no scatter of speeds: the mean of its prior."""
    given = posterior(observations())
    u = np.arange(12.0).reshape(4, 3)
    found = in_slots(given.layout, ["log sigma", "n in 1e-6/m3", "log a"], u)
    assert [slot.name for slot in given.layout.slots][:3] == ["log a", "n in 1e-6/m3", "log sigma"]
    np.testing.assert_array_equal(found[:, :3], u[:, ::-1])
    assert np.unique(found[:, given.layout.track_scatter]) == [pytest.approx(np.log(0.075))]


def test_on_other_events_it_is_the_same_model() -> None:
    given = posterior(observations(speeds=False), "turbulent-drag")
    grid = (0.01, 0.02, 0.05)
    given = given.on_star(Arms({"turbulent-drag.drag": grid}))
    model = fitted_model(given, _draws(given), {"P0": np.zeros(50)})
    new = model.on(_new_events(Event("new", "P1", runout_elevation_m=700.0, volume_m3=2e4)))
    assert new.observations.columns.event_id == ("new",)
    assert new.specification == model.specification
    assert new.posterior.effects == model.posterior.effects
    layout = new.posterior.layout
    (k,) = (k for k, slot in enumerate(layout.slots) if slot.name == "turbulent-drag.drag")
    assert (layout.slots[k].arm, layout.low[k], layout.high[k]) == (grid, grid[0], grid[-1])
    np.testing.assert_array_equal(new.draws, model.draws)
    assert (new.offsets, new.method) == (model.offsets, "marginal")
    # On its own events it is what it was.
    again = model.on(model.observations)
    assert again.posterior.log_density(model.draws[0]) == given.log_density(model.draws[0])


def test_events_without_speeds_stand_on_a_star_that_turns_with_speeds() -> None:
    given = posterior(observations(), "turbulent-drag")
    arms = {"turbulent-drag.drag": (0.01, 0.02, 0.05)}
    given = given.on_star(Arms(arms, {"turbulent-drag.drag": {"log track sigma": 0.5}}))
    model = fitted_model(given, _draws(given), {})
    new = model.on(_new_events(Event("new", "P1", runout_elevation_m=700.0, volume_m3=2e4)))
    assert not any(new.posterior.layout.arms.along.values())
    u = new.draws[0]
    u[new.layout.tables[0]] = 0.03
    assert np.isfinite(new.posterior.log_density(u))


@pytest.mark.parametrize("method", ["marginal", "gibbs", "metropolis"])
def test_the_papers_methods_take_volumes_as_exact(method: MethodName) -> None:
    given = posterior(observations())
    model = fitted_model(given, _draws(given), {}, method).on(observations())
    assert model.method == method
    assert np.all(model.observations.volumes.sd > 0.0) == (method == "marginal")
    assert np.all(model.observations.volumes.sd == 0.0) == (method != "marginal")


@pytest.mark.parametrize("method", ["marginal", "gibbs", "metropolis"])
def test_only_the_scatter_of_metropolis_is_in_metres(method: MethodName) -> None:
    given = posterior(observations())
    draws = _draws(given)
    draws[:, 2] = np.log(np.linspace(100.0, 200.0, 50))
    found = fitted_model(given, draws, {}, method).sigma_m
    if method == "metropolis":
        np.testing.assert_allclose(found, np.linspace(100.0, 200.0, 50))
    else:
        assert found is None


@pytest.mark.parametrize("n", [1, 2, 7, 50, 120])
def test_draws_are_taken_evenly(n: int) -> None:
    given = posterior(observations())
    chosen = fitted_model(given, _draws(given), {}).thinned(n)
    assert len(chosen) == n
    assert chosen[0] == 0
    assert np.all(np.diff(chosen) >= 0)
    if n > 1:
        assert chosen[-1] == 49
        assert np.ptp(np.diff(chosen)) <= 1
    if n >= 50:
        assert set(chosen) == set(range(50))


def test_offsets_of_paths_not_seen_come_from_the_spread() -> None:
    given = posterior(observations(), "path-effect")
    u = np.tile(near(given), (5000, 1))
    u[:, given.layout.spreads["path-effect"]] = 0.5
    known = {f"P{k}": np.full(5000, 0.25) for k in range(5)}
    found = fitted_model(given, u, known).group_offsets(np.random.default_rng(1))
    assert found is not None
    assert observations().columns.paths == tuple(f"P{k}" for k in range(6))
    np.testing.assert_array_equal(found[:, :5], 0.25)
    assert abs(found[:, 5].std() - 0.5 * 0.2) < 0.005
    plain = posterior(observations())
    assert fitted_model(plain, _draws(plain), {}).group_offsets(np.random.default_rng(1)) is None


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
def test_the_median_of_friction_by_hand(distribution: str) -> None:
    given = posterior(observations(), "path-effect", "snow-type", distribution=distribution)
    model = fitted_model(given, _draws(given), {"P1": np.linspace(-0.2, 0.4, 50)})
    columns = model.observations.columns
    volume = np.geomspace(1e3, 1e5, model.observations.n_events)
    found = model.median_friction(volume)
    for i in range(model.observations.n_events):
        frictions = []
        for k, u in enumerate(model.draws):
            at = u, volume[:, None], given.of_events
            location = given.friction.location_and_scatter(*at)[0][i, 0]
            friction = np.exp(location) if distribution == "lognormal" else location
            if columns.path_index[i] == 1:
                friction *= np.exp(np.linspace(-0.2, 0.4, 50)[k])
            frictions.append(friction)
        assert found[i] == pytest.approx(np.median(frictions), rel=1e-12)


def _noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(4, 1000, 2))


def test_independent_draws_converge() -> None:
    result = diagnose_chains(_noise(), np.array([0.3, 0.4, 0.35, 0.35]))
    assert result.converged
    assert result.rhat_max < 1.01
    assert 2500 < result.ess_bulk_min < 6000
    assert result.acceptance == pytest.approx(0.35)


def test_rhat_and_ess_of_a_normal_match_the_textbook() -> None:
    """Autocorrelation 0.9: the ESS is n (1 - 0.9) / (1 + 0.9)."""
    rng = np.random.default_rng(1)
    draws = np.empty((4, 20000, 1))
    x = rng.normal(size=4)
    for i in range(20000):
        x = 0.9 * x + np.sqrt(1 - 0.81) * rng.normal(size=4)
        draws[:, i, 0] = x
    assert diagnose_chains(draws).ess_bulk_min == pytest.approx(80000 / 19, rel=0.15)


def test_a_chain_elsewhere_is_seen() -> None:
    draws = _noise()
    draws[2, :, 1] += 2.0
    result = diagnose_chains(draws)
    assert result.rhat_max > 1.1
    assert not result.converged


def test_few_draws_do_not_pass() -> None:
    assert not diagnose_chains(_noise()[:, :50]).converged


def test_a_stuck_chain_is_counted() -> None:
    draws = _noise()
    draws[1] = draws[1, 0]
    result = diagnose_chains(draws)
    assert result.divergent_or_stuck_chains == 1
    assert result.rhat_max is None
    assert not result.converged


def test_a_chain_that_hardly_accepts_is_stuck() -> None:
    assert (
        diagnose_chains(_noise(), np.array([0.3, 0.3, 0.001, 0.3])).divergent_or_stuck_chains == 1
    )


def test_all_chains_stuck_at_different_places() -> None:
    draws = np.tile(np.arange(4.0)[:, None, None], (1, 100, 1))
    assert diagnose_chains(draws).divergent_or_stuck_chains == 4


def test_a_fixed_parameter_is_left_out() -> None:
    with_constant = np.concatenate([_noise(), np.ones((4, 1000, 1))], axis=2)
    assert diagnose_chains(with_constant) == diagnose_chains(_noise())


def test_draws_that_are_not_finite_never_converge() -> None:
    draws = _noise()
    draws[0, 3, 0] = np.nan
    assert not diagnose_chains(draws).converged
