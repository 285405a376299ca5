"""Leave-one-out against true refits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.scoring import loo
from avahazard.criticism.scoring.held_out import left_out_log_density
from avahazard.criticism.scoring.loo import leave_one_out, smoothed_loo, stacking_weights
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.sampling import sample
from tests.criticism.studies import draws_about, fitted, straight

STEPS = np.linspace(0.0, 1.0, 101)


def test_it_agrees_with_refits() -> None:
    posterior, mode = fitted(straight(20))
    drawn = sample(posterior, n_chains=2, n_draws=500).draws
    found = leave_one_out(fitted_model(posterior, drawn, {}))
    truth = np.array(
        [left_out_log_density(posterior, np.arange(20) == i, mode, drawn)[i] for i in range(20)]
    )
    np.testing.assert_allclose(found.by_event, truth, atol=0.15)
    assert found.n_bad == np.sum(found.pareto_k > 0.7)


def test_a_record_that_rules_the_fit_is_refitted() -> None:
    records = straight(8)
    wild = replace(records.events[3], runout_length_m=4500.0)
    posterior, mode = fitted(
        replace(records, events=(*records.events[:3], wild, *records.events[4:]))
    )
    found = leave_one_out(fitted_model(posterior, draws_about(mode, 1000), {}))
    assert found.pareto_k[3] > 0.7
    assert (found.n_bad, found.n_refitted) == (np.sum(found.pareto_k > 0.7),) * 2
    # The truth by quadrature over both parameters.
    rest = posterior.restricted(np.arange(8) != 3)
    grid = [
        np.array([a, s])
        for a in np.log(0.4) + np.linspace(-1.5, 1.5, 61)
        for s in np.log(0.15) + np.linspace(-1.2, 3.5, 49)
    ]
    weight = np.exp([rest.log_density(u) - rest.log_density(mode.u) for u in grid])
    given = np.exp([rest.event_log_likelihood(u)[3] for u in grid])
    truth = np.log(np.sum(weight * given) / np.sum(weight))
    # So far out in the tail the cut of the weights counts.
    assert np.isclose(found.by_event[3], truth, atol=1.0)


def test_an_event_that_no_draw_doubts_has_the_density_of_any() -> None:
    """Weights without a tail: all equal, or but for a few draws that are as unlikely."""
    rng = np.random.default_rng(0)
    log_likelihood = rng.normal(-5.0, 0.3, (400, 3))
    log_likelihood[:, 1] = -2.0
    log_likelihood[:, 2] = np.where(np.arange(400) < 30, -0.5, 0.0)
    by_event, pareto_k = smoothed_loo(log_likelihood)
    assert np.isfinite(by_event).all()
    assert by_event[1] == -2.0
    assert pareto_k[1] == 0.0
    plain = -np.log(np.mean(np.exp(-log_likelihood), axis=0))
    np.testing.assert_allclose(by_event, plain, atol=0.05)


def test_events_in_parts_are_smoothed_as_together(monkeypatch: pytest.MonkeyPatch) -> None:
    log_likelihood = np.random.default_rng(0).normal(-5.0, 0.3, (400, 7))
    log_likelihood[:, 5] = -2.0
    whole = smoothed_loo(log_likelihood)
    monkeypatch.setattr(loo, "EVENTS_AT_ONCE", 2)
    for part, all_at_once in zip(smoothed_loo(log_likelihood), whole, strict=True):
        np.testing.assert_array_equal(part, all_at_once)


def test_stacking_weights_are_those_of_the_best_mixture() -> None:
    rng = np.random.default_rng(1)
    log_density = rng.normal(-5.0, 1.0, (80, 3)) + np.array([0.0, 0.1, -0.5])
    found = stacking_weights(log_density)
    assert found.sum() == pytest.approx(1.0)

    def score(weights: np.ndarray) -> float:
        return float(np.sum(np.log(np.exp(log_density) @ weights)))

    grid = [np.array([a, b, 1.0 - a - b]) for a in STEPS for b in STEPS if a + b <= 1.0]
    assert score(found) >= max(map(score, grid)) - 1e-9
    assert np.max(np.abs(found - max(grid, key=score))) < 0.02


def test_a_model_that_is_never_better_has_no_weight() -> None:
    log_density = np.array([[-3.0, -4.0], [-5.0, -5.5], [-4.0, -4.1]])
    np.testing.assert_allclose(stacking_weights(log_density), [1.0, 0.0], atol=1e-6)
