"""What is granted first, and what models say that lack it, with about the gain of full fits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.criticism.diagnosis import nuisances
from avahazard.criticism.diagnosis.nuisances import (
    HEAVY_TAILS,
    WORTH_A_NOTE,
    heavier_tails,
    paths_differ,
    with_nuisances_granted,
)
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.assemble import with_effects
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import calibrate_model
from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.report.language import language_of
from avahazard.synth.making import make_dataset
from avahazard.workflow.stored import calibration_result, model_notes
from tests.criticism.lengths import lengths
from tests.criticism.studies import straight

WINTERS, STORMS = "winter-effect", "storm-effect"


def test_groups_too_many_to_cross_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    records = lengths(48, 0.0, seed=3)
    # Two storms of four in each of six winters.
    dates = [f"{1950 + i // 8}-02-{1 + 9 * (i % 8 // 4):02d}" for i in range(48)]
    events = tuple(replace(e, date=d) for e, d in zip(records.events, dates, strict=True))
    observations = build_observations(replace(records, events=events))
    plain = refit(observations, Specification(law="power"), {})
    monkeypatch.setattr(nuisances, "MOST_CROSSED", -1)
    _, granted, too_many = with_nuisances_granted(plain)
    assert set(too_many) == {WINTERS, STORMS}
    assert granted == ()
    monkeypatch.setattr(nuisances, "MOST_CROSSED", 150)
    assert with_nuisances_granted(plain)[2] == ()


PLAIN = Specification(law="constant")


def test_what_the_records_ask_for_is_what_a_bare_model_lacks() -> None:
    observations = build_observations(wild(6))
    student = replace(PLAIN, tails="student")
    found = nuisances.without_those_asked_for(refit(observations, student, {}), PLAIN)
    assert found is not None
    assert found.specification == PLAIN
    # A model that was calibrated with heavy tails keeps them.
    assert nuisances.without_those_asked_for(refit(observations, student, {}), student) is None


def wild(n_wrong: int) -> Records:
    """`straight`, of which every third event from the first on is written down at 2.5 times its
    length, `n_wrong` of them."""
    records = straight(60)
    events = list(records.events)
    for k in range(0, 3 * n_wrong, 3):
        events[k] = replace(events[k], runout_length_m=2.5 * (events[k].runout_length_m or 0.0))
    return replace(records, events=tuple(events))


@pytest.mark.parametrize("n_wrong", [0, 4])
def test_the_gain_of_heavy_tails_is_about_that_of_the_full_fits(n_wrong: int) -> None:
    given = build_observations(wild(n_wrong))
    calibrated = calibrate_model(given, PLAIN, {}, n_draws=60, n_chains=2)
    found = heavier_tails(calibrated)
    assert found is not None
    full = [refit(given, replace(PLAIN, tails=t), {}) for t in ("normal", "student")]  # type: ignore[arg-type]
    expected = full[1].log_likelihood - full[0].log_likelihood
    assert found == pytest.approx(expected, abs=0.5)
    assert (found > HEAVY_TAILS) == (n_wrong > 0)
    result = calibration_result(calibrated, "m", Records(), seed=0)
    told = [note for note in result.notes if "--tails student" in note]
    assert len(told) == (n_wrong > 0)
    for note in told:
        assert note in model_notes(result, False, None)
        for code in ("de", "fr", "it"):
            assert "heavier" not in language_of(code).note(note)


def test_a_model_with_heavy_tails_has_no_note() -> None:
    given = build_observations(wild(4))
    knows = calibrate_model(given, replace(PLAIN, tails="student"), {}, n_draws=60, n_chains=2)
    assert heavier_tails(knows) is None


def _world(seed: int, strength: float) -> Observations:
    effects = {"path-effect": strength} if strength else {}
    return build_observations(make_dataset(seed, 90, 6, effects)[0])


def _model(given: Observations, *effects: str) -> FittedModel:
    specification, facts = with_effects(given, Specification(), effects)
    return calibrate_model(given, specification, facts, n_draws=60, n_chains=2)


@pytest.mark.parametrize(("seed", "strength"), [(1, 0.0), (1, 1.0)])
def test_the_evidence_for_paths_is_about_that_of_the_full_fits(seed: int, strength: float) -> None:
    given = _world(seed, strength)
    calibrated = _model(given)
    found = paths_differ(calibrated, "m")
    assert found is not None
    base = refit(given, Specification(), {})
    full = refit(given, base.specification, base.facts, ("path-effect",), (), base)
    expected = full.evidence - base.evidence
    assert expected - 2.5 < found.values["nats"] < expected + 0.8
    assert (found.values["nats"] > WORTH_A_NOTE) == (strength > 0.0)
    assert found.values["remedy"] == Note("add_effect", model="m", effect="path-effect")
    result = calibration_result(calibrated, "m", Records(), seed=0)
    if strength:
        assert found.values["sd"] == pytest.approx(0.15, rel=0.7)
        assert result.notes[0] == found
    else:
        assert not any("paths differ" in note for note in result.notes)


def test_a_model_with_a_path_effect_has_no_note() -> None:
    given = _world(1, 1.0)
    assert paths_differ(_model(given, "path-effect"), "m") is None
