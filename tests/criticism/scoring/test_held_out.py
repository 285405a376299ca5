"""Held-out fits against quadrature and against data that were simulated from the fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import norm

from avahazard.criticism.scoring.held_out import (
    _student,
    choose_groups,
    fit_draws,
    gathered,
    held_out_predictions,
    held_out_together,
    key_of,
    left_out_log_density,
    offsets_by_group,
)
from avahazard.effects.catalogue import definition
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.model.observations import build_observations
from tests.criticism.studies import draws_about, fitted, slopes, straight, with_speeds


def test_whole_paths_or_five_folds() -> None:
    by_path = choose_groups(build_observations(slopes(n_paths=3)))
    assert by_path.by == "path"
    assert list(by_path.groups) == [0] * 6 + [1] * 6 + [2] * 6
    for records in (slopes(n_paths=2, n_each=10), straight(21)):
        folds = choose_groups(build_observations(records))
        assert folds.by == "fold"
        counts = np.bincount(folds.groups)
        assert len(counts) == 5
        assert np.ptp(counts) <= 1


@pytest.mark.parametrize(
    ("key", "by"), [("path-effect", "fold"), ("winter-effect", "path"), ("turbulent-drag", "path")]
)
def test_events_are_held_out_where_each_path_has_an_offset(key: str, by: str) -> None:
    observations = build_observations(slopes(n_paths=6))
    facts = {"winters": ["winter:2001"]}
    assert choose_groups(observations, [definition(key).build(facts)]).by == by


def test_whole_winters_are_held_out_where_paths_share_winters() -> None:
    observations = build_observations(slopes(n_paths=6))
    n = observations.n_events
    winter = np.append(1990.0 + np.arange(n - 2) % 8, [np.nan, np.nan])
    observations = replace(observations, columns=replace(observations.columns, winter=winter))
    effect = definition("winter-effect").build({"winters": ["winter:1991"]})
    held = choose_groups(observations, [effect])
    assert (held.by, len(np.unique(held.groups))) == ("fold", 5)
    for year in np.unique(winter[:-2]):
        assert len(np.unique(held.groups[winter == year])) == 1
    assert choose_groups(observations).by == "path"


def test_many_paths_are_held_out_in_parts_of_like_size() -> None:
    rng = np.random.default_rng(3)
    groups = rng.permutation(np.repeat(np.arange(60), rng.integers(1, 30, 60)))
    parts = gathered(groups, 24)
    counts = np.bincount(parts)
    assert len(counts) == 24
    assert np.ptp(counts) <= 8
    for group in range(60):
        assert len(np.unique(parts[groups == group])) == 1
    assert list(gathered(groups, 60)) == list(groups)
    np.testing.assert_array_equal(gathered(groups, 24), parts)


def test_each_of_many_paths_is_held_out_whole() -> None:
    held = choose_groups(build_observations(slopes(n_paths=26, n_each=2)))
    assert (held.by, len(np.unique(held.groups)), len(np.unique(held.fits))) == ("path", 26, 24)
    for path in range(26):
        assert len(np.unique(held.fits[held.groups == path])) == 1


def test_density_of_a_record_left_out() -> None:
    """Against the posterior predictive by quadrature over both parameters."""
    posterior, mode = fitted(straight(25))
    out = np.arange(25) == 4
    found = left_out_log_density(posterior, out, mode)[4]
    rest = posterior.restricted(~out)
    a = mode.u[0] + np.linspace(-0.15, 0.15, 41)
    s = mode.u[1] + np.linspace(-0.7, 0.7, 41)
    log_p = np.array([[rest.log_density(np.array([i, j])) for j in s] for i in a])
    p = np.exp(log_p - log_p.max())
    given = np.array([[rest.event_log_likelihood(np.array([i, j]))[4] for j in s] for i in a])
    assert found == pytest.approx(np.log(np.sum(p * np.exp(given)) / np.sum(p)), abs=0.03)


def test_no_event_helps_itself() -> None:
    """A record moved far off changes the density of itself, and its own group's fit not at all."""
    records = straight(30)
    wild = replace(records.events[0], runout_length_m=6000.0)
    posterior, mode = fitted(records)
    moved, _ = fitted(replace(records, events=(wild, *records.events[1:])))
    groups = np.array([0] * 10 + [1] * 10 + [2] * 10)
    own = groups == 0
    before, after = (left_out_log_density(p, own, mode) for p in (posterior, moved))
    np.testing.assert_allclose(after[1:10], before[1:10], atol=1e-9)
    assert after[0] < before[0] - 5.0
    before, after = (held_out_together(p, groups, mode) for p in (posterior, moved))
    assert after[0] < before[0] - 5.0
    assert np.all(np.abs(after[1:] - before[1:]) > 1e-6)


def test_a_path_held_out_has_an_offset_from_the_spread() -> None:
    posterior, mode = fitted(slopes(n_paths=5), "path-effect")
    out = posterior.observations.columns.path_index == 2
    draws = fit_draws(posterior.restricted(~out), mode, 400, "offsets")
    offsets = offsets_by_group(posterior, draws.offsets)
    tau = 0.2 * draws.coordinates[:, posterior.layout.spreads["path-effect"]]
    z = offsets["P2"] / tau
    assert abs(z.mean()) < 0.2
    assert z.std() == pytest.approx(1.0, abs=0.15)
    assert np.std(offsets["P1"] / tau) < 1.0


def test_predictions_are_of_the_fit_without_them() -> None:
    records = with_speeds(slopes(n_paths=3))
    posterior, mode = fitted(records)
    groups = choose_groups(posterior.observations).groups
    model = fitted_model(posterior, draws_about(mode), {})
    shares: list[float] = []
    found = held_out_predictions(model, groups, shares.append)
    assert shares == pytest.approx([1 / 3, 2 / 3, 1.0])
    assert found.records.draws.shape == (18, 300)
    assert found.speeds is not None
    assert found.speeds.draws.shape[0] == 3
    density = np.empty(18)
    for group in range(3):
        out = groups == group
        density[out] = left_out_log_density(posterior, out, mode)[out]
    np.testing.assert_allclose(found.log_density[1:], density[1:], atol=0.2)
    # The event with speeds is far off, and its density depends on few of the draws.
    assert found.log_density[0] == pytest.approx(density[0], abs=1.0)
    again = held_out_predictions(model, groups)
    np.testing.assert_array_equal(again.records.draws, found.records.draws)


def test_held_out_records_are_calibrated() -> None:
    posterior, mode = fitted(straight(200))
    groups = choose_groups(posterior.observations).groups
    found = held_out_predictions(fitted_model(posterior, draws_about(mode), {}), groups).records
    rank = np.mean(found.draws < found.observed[:, None], axis=1)
    inside = np.mean(np.abs(rank - 0.5) < 0.45)
    assert abs(inside - 0.9) < 3.0 * np.sqrt(0.09 / 200)
    assert norm.ppf(np.mean(rank)) == pytest.approx(0.0, abs=0.3)


def test_records_of_a_path_held_out_share_its_offset() -> None:
    """Against a sum over the offset of the path, draw by draw."""
    posterior, mode = fitted(slopes(n_paths=5), "path-effect")
    path = posterior.observations.columns.path_index
    found = held_out_together(posterior, path, mode)
    out = path == 2
    draws = fit_draws(posterior.restricted(~out), mode, 240, key_of(out))
    given = []
    for u in draws.coordinates:
        tau = posterior.layout.spread_values(u)[0]
        offsets = tau * np.linspace(-6.0, 6.0, 61)
        each = [
            posterior.event_log_likelihood(u, b * (np.arange(5) == 2), out)[out].sum()
            for b in offsets
        ]
        given.append(logsumexp(each + norm.logpdf(offsets, 0.0, tau)) + np.log(0.2 * tau))
    twin = logsumexp(np.array(given) + draws.log_weight)
    assert found.shape == (5,)
    assert found[2] == pytest.approx(twin, abs=0.1)
    # One by one they are others: each would have an offset of its own.
    alone = left_out_log_density(posterior, out, mode)[out].sum()
    assert abs(found[2] - alone) > 0.2


def test_a_proposal_bears_a_covariance_that_rounding_has_made_negative() -> None:
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    covariance = turn @ np.diag([1e-3, -4e-7]) @ turn.T
    proposal = _student(np.zeros(2), covariance, np.ones(2))
    rows = proposal.rows(500, np.random.default_rng(1))
    assert np.all(np.isfinite(proposal.logpdf(rows)))
