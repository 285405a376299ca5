"""The linear model of a fit against derivatives of the exact likelihood."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import Refit, refit, refit_with
from avahazard.criticism.screening import linear_model as module
from avahazard.criticism.screening.linear_model import (
    FARTHEST,
    MOST_TIMES,
    LinearModel,
    linear_model,
    winsorised,
)
from avahazard.criticism.screening.screen import screen
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.criticism.lengths import lengths
from tests.inference import studies

PATH_EFFECT = "path-effect"


@cache
def fit(speeds: bool = False) -> Refit:
    return refit(studies.observations(48, 6, speeds), Specification(), {}, (PATH_EFFECT,))


@cache
def model(speeds: bool = False) -> LinearModel:
    return linear_model(fit(speeds).posterior, fit(speeds).mode.u)


def by_difference(key: str, parameter: int, at: float, step: float) -> np.ndarray:
    """Derivative of each event's log likelihood by an effect's parameter, offsets fixed."""
    base = fit()
    entry = find_definition(key)
    observations = base.posterior.observations
    effect = entry.build(entry.facts(observations.columns, observations.sites))
    wider = Posterior(observations, base.specification, (*base.posterior.effects, effect))
    known = {s.name: v for s, v in zip(base.posterior.layout.slots, base.mode.u, strict=True)}
    place = wider.layout.places[key].start + parameter
    scale = wider.layout.slots[place].scale
    values = []
    for value in (at - step, at + step):
        u = np.array([known.get(s.name, s.neutral) for s in wider.layout.slots])
        u[place] = value / scale
        values.append(wider.pinned(u).event_log_likelihood(u, model().offsets))
    return np.asarray((values[1] - values[0]) / (2.0 * step))


def rows_of(key: str) -> np.ndarray:
    entry = find_definition(key)
    observations = fit().posterior.observations
    effect = entry.build(entry.facts(observations.columns, observations.sites))
    return model().of_effect(effect, effect.neutral)


def by_event(rows: np.ndarray) -> np.ndarray:
    """Rows times what is left over, summed by event."""
    of = model()
    first = of.first
    n = of.n_events
    product = rows * of.residual
    return (
        np.add.reduceat(product[: first[-1]], first[:-1])
        + product[first[-1] : first[-1] + n]
        + product[first[-1] + n :]
    )


@pytest.mark.parametrize(
    ("key", "parameter", "at", "step"),
    [
        ("covariate:wind", 2, 0.0, 1e-3),
        ("snow-type", 1, 0.0, 1e-3),
        ("season", 0, 0.0, 1e-3),
        ("force:slope", 1, 2e-4, 5e-5),
        ("force:elevation", 0, 2e-4, 5e-5),
        ("epoch-bias", 0, 0.1, 0.02),
        ("leading-edge", 0, 2e-3, 4e-4),
        ("scatter:snow_type", 1, 0.0, 1e-3),
    ],
)
def test_scores_are_derivatives_of_the_log_likelihood(
    key: str, parameter: int, at: float, step: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MOST_TIMES", np.inf)
    # Events beyond their profile, or with hardly any scatter, have no such derivative.
    sure = model().variances.scatter < 0.01 * model().variances.total
    kept = ~model().gone & ~(sure & key.startswith("scatter:"))
    exact = by_difference(key, parameter, at, step)[kept]
    found = by_event(rows_of(key)[:, parameter])[kept]
    unit = np.max(np.abs(exact))
    assert unit > 0.0
    np.testing.assert_allclose(found, exact, atol=0.03 * unit, rtol=0.05)


def test_a_jump_of_one_event_is_no_derivative() -> None:
    of = model(speeds=True)
    n_rows = np.diff(of.first)
    for alike in (n_rows == 1, n_rows > 1):
        rows = np.zeros(len(of.residual))
        events = np.flatnonzero(alike)
        rows[of.first[events]] = np.linspace(1.0, 2.0, len(events))
        jumps = rows.copy()
        jumps[of.first[events[0]]] = 1e4
        found = of.bounded(jumps)
        most = MOST_TIMES * np.median(jumps[of.first[events]])
        assert found[of.first[events[0]]] == pytest.approx(most)
        np.testing.assert_allclose(
            np.delete(found, of.first[events[0]]), np.delete(rows, of.first[events[0]])
        )
        np.testing.assert_array_equal(of.bounded(rows), rows)


def test_an_event_that_is_impossible_to_first_order_has_a_bound() -> None:
    of = model(speeds=True)
    n_rows = np.diff(of.first)
    for alike in (n_rows == 1, n_rows > 1):
        residual = np.zeros(of.first[-1])
        event = np.flatnonzero(alike)[0]
        selected = slice(of.first[event], of.first[event + 1])
        residual[selected] = 30.0
        found = winsorised(residual, of.first)
        np.testing.assert_allclose(found[selected], FARTHEST)
        # Where all are far off, as by a strong force, none is.
        everywhere = np.full(len(residual), 30.0)
        np.testing.assert_array_equal(winsorised(everywhere, of.first), everywhere)


def test_curvature_of_a_shift_is_what_the_likelihood_has_near_its_mode() -> None:
    """Of all events together: each one's own hangs on where its record fell."""
    of, posterior, u = model(), fit().posterior, fit().mode.u
    n_offsets = len(posterior.plan.names)
    step = 0.02
    values = []
    for shift in (-step, 0.0, step):
        moved = u.copy()
        moved[0] += shift
        values.append(posterior.event_log_likelihood(moved, of.offsets))
    exact = -(values[2] - 2.0 * values[1] + values[0]) / step**2
    found = of.on_friction(np.ones((of.n_events, 1)))[:, 0] ** 2
    assert of.offsets is not None
    assert len(of.offsets) == n_offsets
    assert np.sum(found) == pytest.approx(np.sum(exact), rel=0.15)


def covariance_of(of: LinearModel) -> np.ndarray:
    members, tau = of.members[0].toarray(), of.members[1]
    return np.asarray(np.eye(len(of.residual)) + members @ np.diag(tau**2) @ members.T)


def test_what_nuisances_can_do_is_projected_out() -> None:
    of = model()
    rng = np.random.default_rng(5)
    columns = rng.standard_normal((len(of.residual), 7))
    weight = np.linalg.inv(covariance_of(of))
    for but_last in (0, 1):
        n = len(of.own[1]) - but_last
        own, precision = of.own[0][:, :n], of.own[1][:n]
        inner = own.T @ weight @ own + np.diag(precision)
        taken = np.linalg.solve(inner, own.T @ weight @ columns)
        expected = weight @ (columns - own @ taken)
        found = of.projected(columns, but_last)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)
    # What the law does already is worth what its prior leaves, next to nothing.
    own = own[:, :1]
    assert np.sum(own * of.projected(own)) < 0.05 * np.sum(own * (weight @ own))


@pytest.mark.parametrize("speeds", [False, True])
def test_rows_by_chance_have_the_covariance_of_the_rows(speeds: bool) -> None:
    of = model(speeds)
    n = 4000
    drawn = of.by_chance(n, np.random.default_rng(3))
    expected = covariance_of(of)
    np.testing.assert_allclose(drawn.mean(axis=1), 0.0, atol=5.0 * np.sqrt(expected.max() / n))
    # Squares of a normal have a wider variance.
    found = np.cov(drawn)
    np.testing.assert_allclose(found, expected, atol=15.0 * expected.max() / np.sqrt(n))


@pytest.mark.parametrize("slope", [0.0, 0.04, 0.08])
def test_first_order_gains_are_those_of_full_fits(slope: float) -> None:
    base = refit(build_observations(lengths(90, slope)), Specification(law="power"), {})
    keys = ["covariate:column_1", "covariate:column_2", "covariate:rock", "scatter:rock"]
    screened = screen(base.posterior, base.mode.u, [find_definition(k) for k in keys], 10)
    for c in screened.candidates:
        whole = refit_with(base, c.key)
        gain = whole.mode.log_density - base.mode.log_density
        prior = whole.posterior.layout.log_prior(np.append(base.mode.u, np.zeros(len(c.likely))))
        gain -= float(prior - base.posterior.layout.log_prior(base.mode.u))
        assert c.gain == pytest.approx(gain, abs=0.25, rel=0.2)


def test_a_force_is_seen_where_speeds_are_measured() -> None:
    records, _ = make_dataset(5, 60, 4, {"turbulent-drag": 0.7}, Settings(speeds=0.4))
    observations = build_observations(records)
    base = refit(observations, Specification(), {}, (PATH_EFFECT,))
    drag = find_definition("turbulent-drag")
    (found,) = screen(base.posterior, base.mode.u, [drag], 10).candidates
    whole = refit_with(base, drag.key)
    gain = whole.log_likelihood - base.log_likelihood
    assert found.one_sided
    assert gain > 5.0
    assert found.p_single < 0.01
    assert found.likely[0] > 0.0
    assert found.surprise_of(gain) > found.surprise
