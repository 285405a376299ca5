"""What is fitted in full, what a fit gains by chance, and the price of one among many."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.diagnosis import full_fits
from avahazard.criticism.diagnosis.full_fits import (
    TriedGroup,
    _alone,
    evidence_gain,
    explained_otherwise,
    fitted_in_full,
    plainly_different,
    ways_to_choose,
)
from avahazard.criticism.screening.screen import EXPECTED_SHARE, LEVEL, Screened, Screening
from avahazard.effects.catalogue import definition
from avahazard.effects.effect import Facts
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from benchmarks.worlds import beyond
from tests.inference.studies import observations

LIMIT = definition("observation-limit")


def screened(key: str, surprise: float, gain: float = 10.0) -> Screened:
    return Screened(definition(key), gain, 0.5, 1.0, False, surprise, 1.0, np.empty(0))


def test_a_alone_gains_by_chance_what_its_law_says() -> None:
    """One just above the highest of n stops of each path: -n log of the share below it."""
    given = observations(speeds=False)
    effect = LIMIT.build(LIMIT.facts(given.columns, given.sites))
    posterior = SimpleNamespace(observations=given, effects=(effect,))
    fit: Any = SimpleNamespace(posterior=posterior, observations=given)
    found = _alone(LIMIT, fit, 10.0)
    n_paths = round(found.shape - 0.5)
    # All paths but that whose limit is declared.
    assert n_paths == 5
    rng = np.random.default_rng(4)
    gains = 0.5 * rng.chisquare(1, 20_000)
    for n in (2, 5, 9, 14, 30):
        gains -= n * np.log(np.max(rng.random((20_000, n)), axis=1))
    assert stats.kstest(gains, stats.gamma(found.shape, scale=found.scale).cdf).pvalue > 1e-3
    assert found.surprise == pytest.approx(-stats.gamma.logsf(10.0, found.shape))


def fit(gain: float, evidence: float) -> Any:
    posterior = SimpleNamespace(layout=SimpleNamespace(kinds=None), effects=())
    return SimpleNamespace(
        log_likelihood=20.0 + gain,
        evidence=10.0 + evidence,
        posterior=posterior,
        observations=observations(),
        definition=definition,
    )


def test_one_of_many_of_a_kind_pays_for_the_choice() -> None:
    candidates = [screened(f"scatter:{c}", 9.0) for c in "bcdefg"]
    candidates += [screened(key, 9.0) for key in ("season", "covariate:a", "observation-limit")]
    screening = Screening(tuple(candidates), np.zeros(9), None)
    fits = {c.key: fit(9.0, 7.0) for c in candidates}
    base = fit(0.0, 0.0)
    found = {c.key: evidence_gain(c, fits, base, screening) for c in candidates}
    assert found["season"] == found["covariate:a"] == 7.0
    assert found["scatter:b"] == pytest.approx(7.0 - np.log(6.0))
    assert found["observation-limit"] == 7.0
    one = next(c for c in candidates if c.key == "scatter:b")
    assert evidence_gain(one, fits, base, screening, [one.key]) == 7.0
    # Never more than it gains, and a limit less what it gains by chance.
    fits = {c.key: fit(6.0, 7.0) for c in candidates}
    found = {c.key: evidence_gain(c, fits, base, screening) for c in candidates}
    assert found["season"] == 6.0
    assert found["observation-limit"] == 6.0 - 0.5


def after_fits(
    monkeypatch: pytest.MonkeyPatch, expected: tuple[str, ...], surprise: float
) -> tuple[list[str], Screening]:
    """Season and snow type, each of this surprise, fitted in full or not."""
    asked: list[str] = []

    def each(_base: Any, keys: list[str], *_: Any) -> dict[str, Any]:
        asked.extend(keys)
        return {key: fit(10.0, 5.0) for key in keys}

    monkeypatch.setattr(full_fits, "refit_each", each)
    largest = np.linspace(0.0, 9.99, 999)
    candidates = (screened("season", surprise), screened("snow-type", surprise, 9.0))
    given = Screening(candidates, largest, None)
    _, found = fitted_in_full(fit(0.0, 0.0), given, [], expected)
    return asked, found


def test_a_fit_that_gains_more_is_more_surprising(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, found = after_fits(monkeypatch, (), 2.0)
    assert {"season", "snow-type"} <= set(asked)
    surprise = found.candidates[0].surprise_of(10.0)
    assert surprise > 2.0
    assert [c.surprise for c in found.candidates] == [surprise, surprise]
    assert {c.p_family for c in found.candidates} == {0.001}


def test_what_chance_does_often_is_not_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, found = after_fits(monkeypatch, (), 1.0)
    assert asked == []
    expected = (1.0 + np.sum(np.linspace(0.0, 9.99, 999) >= 1.0)) / 1000.0
    assert [c.p_family for c in found.candidates] == pytest.approx([expected, expected])


def test_beside_one_that_gains_not_what_it_promised_others_are_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """To first order record-error gained 633 nats where it gained none, and hid a force."""
    rounds: list[list[str]] = []
    told: list[float] = []

    def each(_base: Any, keys: list[str], progress: Any, *_: Any) -> dict[str, Any]:
        rounds.append(keys)
        progress(1.0)
        return {key: fit(0.0 if key == "record-error" else 30.0, 20.0) for key in keys}

    monkeypatch.setattr(full_fits, "refit_each", each)
    monkeypatch.setattr(full_fits, "_strong", lambda _, c: (c, 0.0))
    promising = screened("record-error", 600.0, 633.0), screened("season", 28.0, 30.0)
    by_chance = screened("snow-type", 1.0, 2.0)
    given = Screening((*promising, by_chance), np.linspace(0.0, 9.99, 999), None)
    fits, found = fitted_in_full(fit(0.0, 0.0), given, [], progress=told.append)
    assert rounds == [["record-error"], ["season"]]
    assert told == sorted({*told})
    assert told[-1] <= 1.0
    assert [c.key for c in found.candidates if c.p_family <= LEVEL] == ["season"]
    assert set(fits) == {"record-error", "season"}


def test_what_was_left_out_of_the_base_model_is_always_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside speeds the load of curvature gained 19 nats to first order, and 91 once fitted."""
    asked: list[str] = []
    monkeypatch.setattr(full_fits, "refit_each", lambda _, keys, *__: asked.extend(keys) or {})
    monkeypatch.setattr(full_fits, "_strong", lambda _, c: (c, 0.0))
    far = [screened(key, 1.0, 2.0) for key in ("centrifugal", "volume-scatter", "snow-type")]
    given = Screening((screened("season", 28.0, 30.0), *far), np.linspace(0.0, 9.99, 999), None)
    fitted_in_full(fit(0.0, 0.0), given, [])
    assert set(asked) == {"season", "centrifugal"}


def test_what_nuisances_hide_is_fitted_beside_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wind on three paths gained 12 nats beside heavy tails, which it made up, and 69 fitted."""
    asked: list[str] = []

    def each(_: Any, keys: list[str], *__: Any) -> dict[str, Any]:
        asked.extend(keys)
        return {key: fit(69.0, 50.0) for key in keys}

    monkeypatch.setattr(full_fits, "refit_each", each)
    monkeypatch.setattr(full_fits, "_strong", lambda _, c: (c, 0.0))
    given = Screening((screened("season", 0.1, 2.0),), np.linspace(0.0, 9.99, 999), None)
    _, found = fitted_in_full(fit(0.0, 0.0), given, [])
    assert not asked
    assert found.candidates[0].p_family > 0.9
    _, found = fitted_in_full(fit(0.0, 0.0), given, [], hidden=["season"])
    assert asked == ["season"]
    assert found.candidates[0].p_family <= LEVEL


def test_what_is_far_behind_a_short_ascent_gets_no_star(monkeypatch: pytest.MonkeyPatch) -> None:
    least: list[dict[str, float]] = []
    monkeypatch.setattr(full_fits, "refit_each", lambda *given: least.append(given[-1]) or {})
    given = Screening((screened("season", 5.0), screened("snow-type", 4.0)), np.zeros(9), None)
    for best in (3.0, 200.0):
        reached = {"season": 0.0, "snow-type": best}
        monkeypatch.setattr(full_fits, "_strong", lambda _, c, r=reached: (c, r[c.key]))
        fitted_in_full(fit(0.0, 0.0), given, [])
    assert [set(of_each.values()) for of_each in least] == [{1.0}, {170.0}]


def test_what_chance_does_gets_no_star(monkeypatch: pytest.MonkeyPatch) -> None:
    least: dict[str, float] = {}
    monkeypatch.setattr(full_fits, "refit_each", lambda *given: least.update(given[-1]) or {})
    largest = np.linspace(0.0, 29.97, 999)
    candidates = screened("season", 5.0), screened("snow-type", 4.0)
    screening = Screening(candidates, largest, None)
    fitted_in_full(fit(0.0, 0.0), screening, [], expected=("season",))
    assert least["season"] == 1.0
    # With what a rough mode may lack it is not significant.
    found = candidates[1].surprise_of(least["snow-type"] + 4.9)
    assert screening.p_family(found) > LEVEL
    assert screening.p_family(candidates[1].surprise_of(least["snow-type"] + 5.1)) <= LEVEL


def test_declared_ones_have_two_thirds_of_the_level(monkeypatch: pytest.MonkeyPatch) -> None:
    _, found = after_fits(monkeypatch, ("season",), 1.0)
    by_key = {c.key: c for c in found.candidates}
    surprise = by_key["season"].surprise
    assert by_key["season"].p_family == pytest.approx(np.exp(-surprise) / EXPECTED_SHARE)
    assert by_key["season"].p_family <= LEVEL
    # It is significant: the others keep the whole level, else a third of it.
    alone = by_key["snow-type"].p_family
    monkeypatch.setattr(Screened, "surprise_of", lambda *_: 0.0)
    _, without = after_fits(monkeypatch, ("season",), 1.0)
    (snow,) = (c for c in without.candidates if c.key == "snow-type")
    assert snow.p_family == pytest.approx(min(3.0 * alone, 1.0))


@pytest.mark.parametrize(
    ("evidence", "held_out", "expected"),
    [(25.0, 9.0, True), (18.0, 9.0, True), (16.0, 9.0, False), (25.0, -1.0, False)],
    ids=["more", "as-much", "less", "not-held-out"],
)
def test_groups_yield_to_a_candidate_with_their_evidence(
    monkeypatch: pytest.MonkeyPatch, evidence: float, held_out: float, expected: bool
) -> None:
    def each(_base: Any, keys: list[str], **_: Any) -> dict[str, Any]:
        assert keys == ["season"]  # what gains far less is not fitted
        return {"season": fit(30.0, evidence)}

    monkeypatch.setattr(full_fits, "refit_each", each)
    monkeypatch.setattr(full_fits, "held_out_gain", lambda *_: held_out)
    monkeypatch.setattr(full_fits, "likely_values", lambda *_: {})
    strong = replace(screened("season", 20.0, 19.0), p_family=0.001)
    weak = replace(screened("snow-type", 12.0, 12.0), p_family=0.001)
    without = fit(0.0, 0.0)
    group = TriedGroup("winter-effect", 24.0, 1e-9, False, 20.0, 0.1, "winter-effect")
    screening = Screening((strong, weak), np.zeros(9), None)
    assert bool(explained_otherwise(without, screening, group)) is expected


def test_what_is_chosen_among_many_pays_for_their_number() -> None:
    def ways(key: str, fitted: Facts, tried: list[Facts]) -> float:
        observations = SimpleNamespace(columns=None, sites=())
        given: Any = SimpleNamespace(facts={key: fitted}, observations=observations)
        return ways_to_choose(given, definition(key), lambda *_: tried)

    dates: list[Facts] = [{"from_year": 1980.0 + k} for k in range(30)]
    assert ways("change:P01", dates[3], dates) == 30.0
    # Stretches of a drag are as many as those of a friction, beside which there is one smooth.
    parts = [["P01", 100.0 * k, 100.0 * k + 100.0] for k in range(12)]
    every: Facts = {"kind": "friction", "stretches": parts, "ends": [0.0, 1200.0]}
    chosen: Facts = {"kind": "drag", "stretches": parts[3:5], "ends": [0.0, 1200.0]}
    smooth: Facts = {"low": 0.0, "high": 1200.0}
    assert ways("force:distance", chosen, [smooth, every]) == 66.0


def test_groups_differ_plainly_by_evidence_and_level() -> None:
    plain = TriedGroup("path-effect", 20.0, 0.002, True, 18.0, 0.1, "path-effect")
    assert plainly_different([plain], ["path-effect"]) == [plain]
    assert plainly_different([plain], []) == []
    assert plainly_different([replace(plain, evidence=2.0)], ["path-effect"]) == []
    # A winter must be rarer by chance than a path.
    assert plainly_different([replace(plain, p_value=0.004)], ["path-effect"]) == []
    assert plainly_different([replace(plain, persistent=False)], ["path-effect"]) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arm", "changes"), [("change on all paths", ["change:all"]), ("null: winters", [])]
)
def test_a_change_is_no_winter_effect_nor_a_winter_effect_a_change(
    tmp_path: Path, database: str, arm: str, changes: list[str]
) -> None:
    beyond.make(arm, 301, tmp_path / "made")
    import_files(database, [tmp_path / "made"])
    calibrate(database, "base", CalibrateRequest(chains=2, draws=200))
    told = diagnose_model(database, "base", DiagnoseRequest())
    assert [key for key in told.missing if key.startswith("change:")] == changes
    assert "winter-effect" not in told.missing or not changes
