"""Scores against chance: their own distribution, the family's, planted columns, hidden pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.scoring.where_it_fails import event_axes
from avahazard.criticism.screening import screen as module
from avahazard.criticism.screening.linear_model import linear_model
from avahazard.criticism.screening.screen import (
    LEVEL,
    PAIR_LEVEL,
    Block,
    Screening,
    blocks,
    candidate_definitions,
    screen,
)
from avahazard.effects.columns import FALL_HEIGHT
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths, shifted
from tests.inference import studies

POWER = Specification(law="power")


def base_of(slope: float, seed: int = 1, n: int = 90) -> Refit:
    return refit(build_observations(lengths(n, slope, seed)), POWER, {})


def test_the_fall_of_an_event_ends_at_its_stop_and_is_no_candidate() -> None:
    observations = build_observations(lengths(90, 0.0, 1))
    assert FALL_HEIGHT in observations.columns.numbers
    assert FALL_HEIGHT not in event_axes(observations, np.full(90, np.nan))
    keys = [entry.key for entry in candidate_definitions(observations, POWER)]
    assert not any(FALL_HEIGHT in key for key in keys)


def screened(fit: Refit, n_worlds: int = 199) -> Screening:
    entries = candidate_definitions(fit.posterior.observations, fit.specification)
    return screen(fit.posterior, fit.mode.u, entries, n_worlds)


def test_a_planted_column_is_found_and_nothing_where_nothing_is() -> None:
    found = screened(base_of(0.12))
    by_key = {c.key: c for c in found.candidates}
    assert by_key["covariate:column_1"].p_family < LEVEL
    assert by_key["covariate:column_1"].likely[0] == pytest.approx(0.12, abs=0.04)
    assert by_key["covariate:column_2"].p_family > 0.1
    surprises = [c.surprise for c in found.candidates]
    assert surprises == sorted(surprises, reverse=True)
    nothing = screened(base_of(0.0, seed=3))
    assert nothing.candidates[0].p_family > LEVEL
    for each in (found, nothing):
        assert stats.chi2.sf(2.0 * each.critical_gain, 1) < LEVEL / 3.0


def test_a_law_far_from_this_one_is_seen() -> None:
    """Friction that falls over a narrow range of volumes: no other law bends so beside this one."""
    records = lengths(180, seed=4)
    volume = np.array([e.volume_m3 for e in records.events], np.float64)
    step = -0.3 / (1.0 + np.exp(-np.log(volume / 1e5) / 0.2))
    columns = {"column_1": np.array([e.covariates["column_1"] for e in records.events])}
    fit = refit(build_observations(shifted(records, columns, step)), Specification(), {})
    (found,) = screen(fit.posterior, fit.mode.u, [find_definition("volume-law")]).candidates
    gain = max(
        refit(fit.observations, Specification(law=law), {}).log_likelihood
        for law in ("rational", "asymptotic", "power")
    )
    assert found.p_family < LEVEL
    assert found.gain > 0.5 * (gain - fit.log_likelihood)


def test_no_candidates_are_no_screening() -> None:
    fit = base_of(0.0)
    found = screen(fit.posterior, fit.mode.u, [], 7)
    assert (found.candidates, found.pair, len(found.largest)) == ((), None, 7)


@cache
def by_motion() -> tuple[Refit, tuple[str, ...]]:
    """A model of stops on paths, and candidates of every kind."""
    observations = studies.observations(48, 6, speeds=False)
    fit = refit(observations, Specification(), {}, ("path-effect",))
    return fit, tuple(c.key for c in candidate_definitions(observations, fit.specification))


@pytest.mark.parametrize("n_nulls", [50, pytest.param(400, marks=pytest.mark.slow)])
def test_the_family_and_pairs_hold_their_level(
    monkeypatch: pytest.MonkeyPatch, n_nulls: int
) -> None:
    """Of sets of rows in which nothing is missing, about the level's share shows something."""
    fit, keys = by_motion()
    model = linear_model(fit.posterior, fit.mode.u)
    entries = [find_definition(k) for k in keys]
    tried = blocks(entries, model)
    monkeypatch.setattr(module, "blocks", lambda *_: tried)
    nulls = model.by_chance(n_nulls, np.random.default_rng(17))
    least, pairs = [], []
    for k, rows in enumerate(nulls.T):
        monkeypatch.setattr(module, "linear_model", lambda *_, r=rows: replace(model, residual=r))
        found = screen(fit.posterior, fit.mode.u, entries, 99, seed=k)
        least.append(found.candidates[0].p_family)
        assert found.pair is not None
        pairs.append(found.pair.p_value)
    for p_values in (least, pairs):
        for level in (0.05, 0.2):
            n = int(np.sum(np.array(p_values) <= level))
            assert stats.binomtest(n, n_nulls, level).pvalue > 1e-3


@pytest.mark.parametrize("side", [0, 1])
def test_the_tail_of_a_gain_is_that_of_simulated_scores(side: int) -> None:
    rng = np.random.default_rng(6)
    n = 1 if side else 4
    root = rng.standard_normal((n, n)) + 2.0 * np.eye(n)
    bend = root @ root.T
    precision = np.linspace(0.5, 8.0, n)
    block = Block("b", np.empty((0, n)), precision, np.zeros(n), side)
    scores = np.linalg.cholesky(bend) @ rng.standard_normal((n, 20_000))
    scores[:, 0] = np.abs(scores[:, 0])
    gains, shape, scale, change = module._gains(scores, bend, block)
    whole = bend + np.diag(precision)
    assert gains[1] in (
        0.0,
        pytest.approx(0.5 * scores[:, 1] @ np.linalg.solve(whole, scores[:, 1])),
    )
    np.testing.assert_allclose(change, np.linalg.solve(whole, scores[:, 0]))
    if side:
        assert np.mean(gains == 0.0) == pytest.approx(0.5, abs=0.02)
    surprise = module._surprise(gains, shape, scale, side != 0)
    for level in (0.2, 0.05, 0.005):
        share = float(np.mean(surprise >= -np.log(level)))
        assert share == pytest.approx(level, rel=0.15, abs=4.0 * np.sqrt(level / 20_000))


def test_two_that_hide_each_other_are_seen_together() -> None:
    rng = np.random.default_rng(8)
    n = 90
    cold = rng.standard_normal(n)
    wind = 0.95 * cold + np.sqrt(1.0 - 0.95**2) * rng.standard_normal(n)
    columns = {"cold": cold, "wind": wind}

    def pair(strength: float) -> module.PairTest:
        records = shifted(lengths(n, 0.0, 2), columns, strength * (cold - wind))
        fit = refit(build_observations(records), POWER, {})
        entries = [find_definition(k) for k in ("covariate:cold", "covariate:wind", "season")][:2]
        found = screen(fit.posterior, fit.mode.u, entries, 399).pair
        assert found is not None
        return found

    hidden, nothing = pair(0.4), pair(0.0)
    assert set(hidden.keys) == {"covariate:cold", "covariate:wind"}
    assert hidden.p_value <= PAIR_LEVEL
    assert nothing.p_value > PAIR_LEVEL


def test_equal_seeds_are_equal_screenings() -> None:
    fit = base_of(0.05)

    def largest(seed: int) -> Sequence[float]:
        entries = [find_definition("covariate:column_1")]
        return list(screen(fit.posterior, fit.mode.u, entries, 20, seed).largest)

    assert largest(4) == largest(4) != largest(5)


@pytest.mark.slow
def test_of_records_in_which_nothing_is_missing_few_show_anything() -> None:
    least = [screened(base_of(0.0, seed)).candidates[0].p_family for seed in range(100, 220)]
    n = int(np.sum(np.array(least) <= 0.1))
    print(n, np.sum(np.array(least) <= LEVEL))
    assert stats.binomtest(n, len(least), 0.1, "greater").pvalue > 1e-2
