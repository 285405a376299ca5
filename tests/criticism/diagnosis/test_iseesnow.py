"""Twelve codes of other groups on one slope, with Voellmy's drag: 12 events with 538 speeds."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.refits import refit, refit_with
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.reading import read_records

DRAG = "turbulent-drag"


@pytest.fixture(scope="module")
def observations(shared_data: Path) -> Observations:
    return build_observations(read_records([shared_data / "iseesnow-voellmy"]))


def test_one_effect_more_is_never_worse(observations: Observations) -> None:
    """Its star is long and bent: the mode on it once lay where no exact table has one."""
    base = refit(observations, Specification(), {})
    wider = refit_with(base, "force:distance")
    assert wider.log_likelihood > base.log_likelihood + 30.0


@pytest.mark.slow
def test_drag_is_named_alone(observations: Observations) -> None:
    found = diagnose(observations, Specification(), {})
    assert (found.verdict, found.missing) == ("missing-effect", (DRAG,))
    leader = found.candidates[0]
    assert leader.fit is not None
    # To first order at neutral it seems to be no force at all; a short ascent shows it.
    gained = leader.fit.log_likelihood - found.base.log_likelihood
    assert leader.screened.gain == pytest.approx(gained, abs=1.0)
