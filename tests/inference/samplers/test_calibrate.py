"""Calibration of models on observations by the marginal method."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.records.collection import Records
from avahazard.records.event import Event
from tests.workflow.twin import TRUTH, twin_study


def _straight(n: int = 120, slope: float = 0.1) -> Records:
    """Events without a profile on a power law."""
    rng = np.random.default_rng(0)
    volume = np.exp(rng.normal(11.0, 1.5, n))
    mu = volume**-slope * np.exp(0.1 * rng.standard_normal(n))
    return Records(
        events=tuple(
            Event(
                f"E{k}",
                fall_height_m=1000.0,
                runout_length_m=1000.0 / m,
                volume_m3=v,
                volume_rel_sigma=0.01,
            )
            for k, (v, m) in enumerate(zip(volume.tolist(), mu.tolist(), strict=True))
        )
    )


def test_marginal_is_the_regression_where_that_is_all_there_is() -> None:
    records = _straight()
    observations = build_observations(records)
    found = calibrate_model(observations, Specification(law="power"), {}, n_draws=500, seed=1)
    x = observations.columns.log_volume
    y = np.log([e.fall_height_m / e.runout_length_m for e in records.events])
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    beta = found.chains.draws[..., found.chains.names.index("beta")]
    assert beta.mean() == pytest.approx(-slope, abs=0.2 * np.sqrt(covariance[0, 0]))
    assert beta.std() == pytest.approx(np.sqrt(covariance[0, 0]), rel=0.15)
    slots = [slot.name for slot in found.posterior.layout.slots]
    assert slots[:2] == ["log alpha", "beta"]
    assert (found.n_events, found.offsets, found.notes) == (120, {}, ())


def test_the_star_is_that_which_was_sampled() -> None:
    observations = twin_study("scey", "saugy")
    specification, facts = with_effects(
        observations, Specification(law="constant"), ["turbulent-drag"]
    )
    found = calibrate_model(observations, specification, facts, n_chains=2, n_draws=50)
    whole = assemble(observations, specification, facts).layout
    drag = next(s for s in whole.slots if s.name == "turbulent-drag.drag")
    layout = found.posterior.layout
    (k,) = (k for k, s in enumerate(layout.slots) if s.name == drag.name)
    assert layout.arms == {drag.name: layout.slots[k].arm}
    assert layout.slots[k].arm != drag.arm
    draws = found.draws[:, k]
    assert drag.low <= draws.min() <= draws.max() <= drag.high


def test_marginal_finds_the_twins_law() -> None:
    found = calibrate_model(twin_study(), Specification(), {}, n_draws=400, seed=2)
    assert found.chains.diagnostics.converged
    for k, name in enumerate(found.chains.names):
        low, high = np.quantile(found.chains.draws[..., k], [0.05, 0.95])
        assert low < TRUTH[name] < high


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "scatter", "distribution", "tails"),
    list(
        product(
            ("exponential", "power", "rational", "constant"),
            ("constant", "volume"),
            ("lognormal", "normal"),
            ("normal", "student"),
        )
    ),
)
def test_every_choice_converges_on_the_twin(law, scatter, distribution, tails) -> None:
    asked = Specification(law=law, scatter=scatter, distribution=distribution, tails=tails)
    specification, facts = with_effects(twin_study(), asked, [])
    found = calibrate_model(twin_study(), specification, facts, seed=4)
    assert found.chains.diagnostics.converged
    # Whatever the form, friction at 20 000 m3 is that of the twin.
    posterior = assemble(twin_study(), specification, facts)
    draws = found.draws[::20]
    level = [posterior.location_and_scatter(u, np.array([[2e4]]))[0][0, 0] for u in draws]
    mu = np.exp(level) if distribution == "lognormal" else np.array(level)
    truth = TRUTH["a"] * np.exp(-TRUTH["n"] * 2e4)
    assert abs(mu.mean() - truth) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("key", ["path-effect", "turbulent-drag", "season", "path-section"])
def test_an_effect_that_is_not_there_is_not_found(key: str) -> None:
    specification, facts = with_effects(twin_study(), Specification(), [key])
    found = calibrate_model(twin_study(), specification, facts, seed=5)
    assert found.chains.diagnostics.converged
    for k, name in enumerate(found.chains.names):
        if not name.startswith(key):
            continue
        draws = found.chains.draws[..., k]
        if name in ("path-effect.tau", "turbulent-drag.drag"):  # they cannot be below 0
            assert np.quantile(draws, 0.005) < 0.05 * np.quantile(draws, 0.995)
        else:
            # One of the twin's four lies 2.9 away, by the chance of its events.
            assert abs(np.mean(draws)) < 3.5 * np.std(draws)
