"""Heavy tails of friction, and wrong records, are told of a model that does not know them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.criticism.diagnosis.heavier_tails import heavier_tails
from avahazard.criticism.diagnosis.nuisances import HEAVY_TAILS
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.records.collection import Records
from avahazard.report.language import language_of
from avahazard.workflow.stored.calibration import calibration_result
from avahazard.workflow.stored.notes import model_notes
from tests.criticism.studies import straight

PLAIN = Specification(law="constant")


def wild(n_wrong: int) -> Records:
    """`straight`, of which every third event from the first on is written down at 2.5 times its
    length, `n_wrong` of them."""
    records = straight(60)
    events = list(records.events)
    for k in range(0, 3 * n_wrong, 3):
        events[k] = replace(events[k], runout_length_m=2.5 * (events[k].runout_length_m or 0.0))
    return replace(records, events=tuple(events))


@pytest.mark.parametrize("n_wrong", [0, 4])
def test_the_gain_is_about_that_of_the_full_fits(n_wrong: int) -> None:
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
    assert (result.heavier_tails is not None) == (n_wrong > 0)
    for note in told:
        assert note in model_notes(result, False, None)
        for code in ("de", "fr", "it"):
            assert "heavier" not in language_of(code).told(note)


def test_a_model_that_knows_them_is_not_told() -> None:
    given = build_observations(wild(4))
    knows = calibrate_model(given, replace(PLAIN, tails="student"), {}, n_draws=60, n_chains=2)
    assert heavier_tails(knows) is None
