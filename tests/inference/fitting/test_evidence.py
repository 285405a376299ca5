"""The evidence against the integral itself, summed over a fine grid of the parameters."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import logsumexp, ndtr

from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.fitting import mode as mode_module
from avahazard.inference.fitting.mode import Mode, find_mode, log_evidence, log_prior_mass
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Arms
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths
from tests.inference import studies


def summed(posterior: Posterior, mode: Mode, n: int, reach: float = 6.0) -> float:
    """Log of the integral of the density over a grid of midpoints about the mode."""
    sd = np.sqrt(np.diag(mode.covariance))
    low = np.maximum(mode.u - reach * sd, posterior.layout.low)
    high = np.minimum(mode.u + reach * sd, posterior.layout.high)
    axes = [a + (b - a) * (np.arange(n) + 0.5) / n for a, b in zip(low, high, strict=True)]
    values = [posterior.log_density(np.array(u)) for u in product(*axes)]
    return float(logsumexp(values) + np.sum(np.log((high - low) / n)))


def test_two_parameters() -> None:
    fit = refit(build_observations(lengths(40)), Specification(law="constant"), {})
    assert len(fit.posterior.layout.slots) == 2
    expected = summed(fit.posterior, fit.mode, 61) - log_prior_mass(fit.posterior)
    found = log_evidence(fit.posterior, fit.mode)
    assert found.value == pytest.approx(expected, abs=4.0 * found.error)
    assert found.error < 0.1


def test_paths_that_do_not_differ_lean_against_the_bound() -> None:
    model = studies.posterior(studies.observations(60, speeds=False), "path-effect", law="constant")
    mode = find_mode(model)
    expected = summed(model, mode, 13, reach=8.0) - log_prior_mass(model)
    found = log_evidence(model, mode)
    assert found.value == pytest.approx(expected, abs=4.0 * found.error + 0.05)


def test_an_effect_on_the_motion() -> None:
    given = studies.observations(60, speeds=False)
    fit = refit(given, Specification(law="constant"), {}, ("forest-drag",))
    # The sum stands on interpolated tables throughout, the evidence on exact ones at the mode.
    at_mode = fit.posterior.exact_log_likelihood(fit.mode.u)
    at_mode -= fit.posterior.log_likelihood(fit.mode.u)
    expected = summed(fit.posterior, fit.mode, 15) - log_prior_mass(fit.posterior) + at_mode
    found = log_evidence(fit.posterior, fit.mode)
    assert found.value == pytest.approx(expected, abs=4.0 * found.error + 0.05)


def test_priors_count_over_the_ranges_of_the_effects_whatever_the_grids() -> None:
    model = studies.posterior(studies.observations(speeds=False), "forest-drag")
    slot = next(s for s in model.layout.slots if s.arm)
    finer = model.on_star(Arms({slot.name: tuple(float(v) for v in np.linspace(0.1, 0.4, 7))}))
    assert log_prior_mass(finer) == log_prior_mass(model)
    mass = 0.0
    for s in model.layout.slots:
        share = ndtr((s.high - s.mean) / s.sd) - ndtr((s.low - s.mean) / s.sd)
        mass += np.log(share * s.sd * np.sqrt(2.0 * np.pi))
    assert log_prior_mass(model) == pytest.approx(mass, abs=1e-9)


def test_a_mode_far_wider_than_its_range_has_an_evidence() -> None:
    """Against a bound the curvature may be next to none: draws about it all missed."""
    model = studies.posterior(studies.observations(12, 6), law="constant")
    narrow = model.on_star(Arms({"log track sigma": (-2.53, -2.52, -2.51, -2.5)}))
    mode = find_mode(narrow)
    wide = mode.covariance.copy()
    wide[-1, :] = wide[:, -1] = 0.0
    wide[-1, -1] = 400.0
    found = log_evidence(narrow, Mode(mode.u, mode.log_density, wide))
    plain = wide.copy()
    plain[-1, -1] = 1e-4
    expected = log_evidence(narrow, Mode(mode.u, mode.log_density, plain))
    assert found.value == pytest.approx(expected.value, abs=5.0 * (found.error + expected.error))


def test_a_mode_that_is_not_quite_the_mode_gives_the_same_evidence() -> None:
    fit = refit(build_observations(lengths(40)), Specification(), {})
    off = Mode(fit.mode.u + 0.5 * np.sqrt(np.diag(fit.mode.covariance)), 0.0, fit.mode.covariance)
    found = log_evidence(fit.posterior, fit.mode)
    assert log_evidence(fit.posterior, off).value == pytest.approx(
        found.value, abs=6.0 * found.error
    )
    narrow = Mode(fit.mode.u, 0.0, 0.1 * fit.mode.covariance)
    assert log_evidence(fit.posterior, narrow).value == pytest.approx(
        found.value, abs=6.0 * found.error
    )


@pytest.mark.parametrize(
    ("end", "n"), [(0.1, 8), (0.45, 9)], ids=["no-draw-within", "a-few-draws-within"]
)
def test_a_spread_wider_than_the_star_is_drawn_in(
    monkeypatch: pytest.MonkeyPatch, end: float, n: int
) -> None:
    """A normal of `n` coordinates that ends a part of a standard deviation off."""
    monkeypatch.setattr(mode_module, "log_prior_mass", lambda _: 0.0)

    def log_densities(u: np.ndarray) -> np.ndarray:
        return np.where(np.all(np.abs(u) < end, axis=1), -0.5 * np.sum(u**2, axis=1), -np.inf)

    layout = SimpleNamespace(low=np.full(n, -9.0), high=np.full(n, 9.0))
    nodes = SimpleNamespace(varies=False)
    model: Any = SimpleNamespace(layout=layout, nodes=nodes, log_densities=log_densities)
    found = log_evidence(model, Mode(np.zeros(n), 0.0, np.eye(n)))
    one = np.sqrt(2.0 * np.pi) * (ndtr(end) - ndtr(-end))
    assert found.value == pytest.approx(n * np.log(one), abs=0.5)
