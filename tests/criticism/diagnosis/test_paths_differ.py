"""Paths that differ are told of a model that does not know it, with about the full evidence."""

from __future__ import annotations

import pytest

from avahazard.criticism.diagnosis.paths_differ import WORTH_A_NOTE, paths_differ
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.likelihood.assemble import with_effects
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.records.collection import Records
from avahazard.synth.making import make_world
from avahazard.workflow.stored.calibration import calibration_result


def _world(seed: int, strength: float) -> Observations:
    effects = {"path-effect": strength} if strength else {}
    return build_observations(make_world(seed, 90, 6, effects)[0])


def _model(given: Observations, *effects: str) -> FittedModel:
    specification, facts = with_effects(given, Specification(), effects)
    return calibrate_model(given, specification, facts, n_draws=60, n_chains=2)


@pytest.mark.parametrize(("seed", "strength"), [(1, 0.0), (1, 1.0)])
def test_the_evidence_is_about_that_of_the_full_fits(seed: int, strength: float) -> None:
    given = _world(seed, strength)
    calibrated = _model(given)
    found = paths_differ(calibrated)
    assert found is not None
    base = refit(given, Specification(), {})
    full = refit(given, base.specification, base.facts, (found.effect,), (), base)
    expected = full.evidence - base.evidence
    assert expected - 2.5 < found.evidence < expected + 0.8
    assert (found.evidence > WORTH_A_NOTE) == (strength > 0.0)
    assert found.lacking is None
    result = calibration_result(calibrated, "m", Records(), seed=0)
    if strength:
        assert found.sd == pytest.approx(0.15, rel=0.7)
        assert result.path_spread is not None
        assert f"paths differ by sd {found.sd:.2f}" in result.notes[0]
        assert "avahazard add m path-effect" in result.notes[0]
    else:
        assert result.path_spread is None
        assert not any("paths differ" in note for note in result.notes)


def test_a_model_that_knows_them_is_not_told() -> None:
    given = _world(1, 1.0)
    assert paths_differ(_model(given, "path-effect")) is None
