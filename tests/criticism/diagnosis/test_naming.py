"""Who is named: what was declared first, and never what the measured force denies."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis import naming
from avahazard.criticism.diagnosis.force_witness import ForceWitness
from avahazard.criticism.diagnosis.full_fits import group_tests
from avahazard.criticism.diagnosis.naming import MARGIN, leaders, name_effects, verdict_of
from avahazard.criticism.diagnosis.record_faults import impossible_stops
from avahazard.criticism.diagnosis.refits import Question, Refit, refit
from avahazard.criticism.screening.screen import Screened, Screening
from avahazard.effects.catalogue import definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Path, Profile, Records
from tests.criticism.lengths import lengths, shifted
from tests.inference import studies

NONE = Screening((), np.zeros(9), None)


def screened(key: str) -> Screened:
    return Screened(definition(key), 10.0, 0.5, 1.0, False, 8.0, 0.001, np.zeros(1))


def test_one_that_was_declared_needs_no_margin() -> None:
    ranked = [screened("season"), screened("snow-type")]
    evidence = {"season": 2.0, "snow-type": 1.0}
    assert leaders(ranked, evidence) == []
    assert leaders(ranked[1:], evidence, expected=["snow-type"]) == ranked[1:]
    assert leaders(ranked[1:], {"snow-type": -1.0}, expected=["snow-type"]) == []


def test_of_those_that_explain_alike_the_simplest_is_named() -> None:
    season, change, pair = (
        screened(key) for key in ("season", "change:all", "interaction:wind*snow_type")
    )
    evidence = {"season": 10.0, "change:all": 12.0, "interaction:wind*snow_type": 12.5}
    assert leaders([pair, change, season], evidence) == [season]
    assert leaders([pair, change], evidence) == [change]
    # One that does not explain the leader comes behind it.
    assert leaders([pair, change, season], evidence, explains=lambda *_: False) == [pair]
    by_season = leaders([pair, change], evidence, explains=lambda one, _: one == "season")
    assert by_season == [pair]
    evidence["season"] = 9.0
    assert leaders([pair, change, season], evidence) == [change]
    evidence["change:all"] = 9.0
    assert leaders([pair, change, season], evidence) == [pair]


def test_what_leads_by_a_single_event_leads_not() -> None:
    drag, smooth = screened("turbulent-drag"), screened("force:speed")
    evidence = {"turbulent-drag": 20.0, "force:speed": 28.0}

    def fits(*leads: float) -> Any:
        known = {"turbulent-drag": np.zeros(3), "force:speed": np.array(leads)}
        return {key: SimpleNamespace(by_event=values) for key, values in known.items()}

    assert leaders([smooth, drag], evidence, fits(3.0, 2.5, 2.5)) == [smooth]
    assert leaders([smooth, drag], evidence, fits(5.5, 1.5, 1.0)) == [drag]
    # What leads over one that is not simpler needs no such witness.
    swapped = {"turbulent-drag": 28.0, "force:speed": 20.0}
    assert leaders([drag, smooth], swapped, fits(-9.0, 0.0, 0.0)) == [drag]


@pytest.fixture(scope="module")
def base() -> Refit:
    return refit(studies.observations(speeds=True), Specification(), {})


@pytest.mark.parametrize(
    ("witness", "verdict", "missing"),
    [
        (None, "missing-effect", ("turbulent-drag",)),
        (ForceWitness(0.003, 0.001, 0.004), "missing-effect", ("turbulent-drag",)),
        (ForceWitness(-0.003, 0.001, 0.004), "unexplained", None),
    ],
)
def test_a_name_on_the_motion_has_its_witness(
    base: Refit,
    monkeypatch: pytest.MonkeyPatch,
    witness: ForceWitness | None,
    verdict: str,
    missing: tuple[str, ...] | None,
) -> None:
    monkeypatch.setattr(naming, "force_witness", lambda *_given: witness)
    monkeypatch.setattr(naming, "held_out_gain", lambda *_given: 1.0)
    question = Question(base, {"turbulent-drag": base}, NONE)
    found = name_effects(question, [screened("turbulent-drag")], {"turbulent-drag": 9.0})
    assert found.verdict == verdict
    if missing is None:
        assert found.missing[0] in ("speed:place_along_path", "speed:predicted_speed_m_s")
    else:
        assert found.missing == missing


def test_declared_ones_come_before_those_of_more_evidence(
    base: Refit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(naming, "force_witness", lambda *_given: None)
    monkeypatch.setattr(naming, "held_out_gain", lambda *_given: 1.0)
    ranked = [screened("release-elevation"), screened("snow-type")]
    evidence = {"release-elevation": 9.0, "snow-type": 3.5}
    question = Question(base, {"release-elevation": base, "snow-type": base}, NONE)
    assert name_effects(question, ranked, evidence).missing == ("release-elevation",)
    named = name_effects(question, ranked, evidence, ["snow-type"])
    assert (named.verdict, named.missing) == ("missing-effect", ("snow-type",))
    evidence["snow-type"] = -0.5
    named = name_effects(question, ranked, evidence, ["snow-type"])
    assert named.missing == ("release-elevation",)


def beside_another(monkeypatch: pytest.MonkeyPatch, base: Refit, more: float) -> None:
    """Let every candidate gain on held-out records, and have `more` evidence beside another."""
    monkeypatch.setattr(naming, "held_out_gain", lambda *_given: 1.0)
    both = replace(base, evidence=base.evidence + more)
    monkeypatch.setattr(naming, "refit_with", lambda *_given: both)


@pytest.mark.parametrize(("more", "named"), [(9.0, "interaction:wind*new"), (5.0, "season")])
def test_a_pair_pays_for_its_choice_beside_a_column_too(
    base: Refit, monkeypatch: pytest.MonkeyPatch, more: float, named: str
) -> None:
    """Of 12 nats of evidence the pair pays 4 for being one of many."""
    beside_another(monkeypatch, base, more)
    ranked = [screened("interaction:wind*new"), screened("season")]
    evidence = {"interaction:wind*new": 8.0, "season": 7.0}
    pair = replace(base, evidence=base.evidence + 12.0)
    question = Question(base, {"interaction:wind*new": pair, "season": base}, NONE)
    assert name_effects(question, ranked, evidence).missing == (named,)


@pytest.mark.parametrize(("more", "named"), [(9.0, "snow-type"), (1.0, "observation-limit")])
def test_a_limit_comes_last(
    base: Refit, monkeypatch: pytest.MonkeyPatch, more: float, named: str
) -> None:
    """Snow has `more` evidence beside the limit, which leads."""
    beside_another(monkeypatch, base, more)
    ranked = [screened("observation-limit"), screened("snow-type"), screened("season")]
    evidence = {"observation-limit": 19.0, "snow-type": 8.0, "season": 2.0}
    question = Question(base, dict.fromkeys(evidence, base), NONE)
    assert name_effects(question, ranked, evidence).missing == (named,)
    if named == "observation-limit":
        # What effects leave over narrows the stops as well.
        wider = replace(base, specification=Specification(effects=("season",)))
        of_wider = replace(question, base=wider)
        assert name_effects(of_wider, ranked, evidence).missing == ()
        wider = replace(base, specification=Specification(effects=("path-effect",)))
        of_wider = replace(question, base=wider)
        assert name_effects(of_wider, ranked, evidence).missing == (named,)
    # One that was declared was the only question.
    declared = name_effects(question, ranked, evidence, ["observation-limit"])
    assert declared.missing == ("observation-limit",)


def test_the_force_is_asked_of_the_law_where_there_is_one(
    base: Refit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A narrow band that tracks show, of which the smooth is denied."""
    law = refit(base.observations, Specification(), {}, ("cohesion",))
    said = {
        "turbulent-drag": ForceWitness(-0.003, 0.001, 0.004),
        "cohesion": ForceWitness(0.3, 0.1, 0.2),
    }
    monkeypatch.setattr(naming, "force_witness", lambda _posterior, _mode, key: said[key])
    monkeypatch.setattr(naming, "held_out_gain", lambda *_given: 1.0)
    question = Question(base, {"turbulent-drag": base}, NONE)
    ranked, evidence = [screened("turbulent-drag")], {"turbulent-drag": 9.0}
    assert name_effects(question, ranked, evidence).verdict == "unexplained"
    found = name_effects(question, ranked, evidence, of_laws={"turbulent-drag": law})
    assert found.missing == ("turbulent-drag",)
    assert found.witnesses["turbulent-drag"] == pytest.approx((0.006, 0.002, 0.004))


def test_stops_on_ground_too_steep_are_told() -> None:
    """A bench, a steep step of 200 m below it, and a flat run-out: nothing stops on the step."""
    x = np.arange(0.0, 2001.0, 10.0)
    slope = np.where(x < 500, 0.6, np.where(x < 900, 0.2, np.where(x < 1150, 0.9, 0.1)))
    y = 1500.0 - np.concatenate([[0.0], np.cumsum(10.0 * slope[:-1])])
    stops = {"bench": 850.0, "step": 1030.0, "flat": 1600.0}
    events = tuple(
        Event(
            name,
            "P",
            runout_elevation_m=float(np.interp(at, x, y)),
            runout_sigma_m=5.0,
            volume_m3=1e4,
        )
        for name, at in stops.items()
    )
    given = build_observations(Records((Path("P"),), (Profile("P", x, y),), events))
    found = impossible_stops(refit(given, Specification(law="constant"), {}))
    assert found == ("step",)


FOREST, SEASON = definition("forest-drag"), definition("season")
WIND, SNOW = definition("covariate:wind"), definition("covariate:snow_type")


@pytest.mark.parametrize(
    ("named", "verdict"),
    [
        ((), "adequate"),
        ((FOREST,), "missing-effect"),
        ((FOREST, SEASON), "ambiguous"),
        ((WIND,), "unexplained"),
        ((WIND, SNOW), "unexplained"),
        ((WIND, SEASON), "ambiguous"),
    ],
)
def test_only_a_cause_is_a_missing_effect(named: tuple[Any, ...], verdict: str) -> None:
    assert verdict_of(named) == (verdict, tuple(entry.key for entry in named))


def test_winters_need_evidence_for_a_name() -> None:
    records = lengths(48, 0.0, seed=3)
    winters = np.arange(48) // 6
    dates = [f"{1950 + w}-02-01" for w in winters]
    named = []
    for spread in (0.0, 0.3):
        shift = spread * np.random.default_rng(7).standard_normal(8)[winters]
        moved = shifted(records, {}, shift)
        events = tuple(replace(e, date=d) for e, d in zip(moved.events, dates, strict=True))
        observations = build_observations(replace(moved, events=events))
        base = refit(observations, Specification(law="power"), {}, ("winter-effect",))
        (test,) = group_tests(base)
        named.append(test.evidence > MARGIN)
    assert named == [False, True]
