"""Codes of other groups on one slope: twelve with Voellmy's drag, eleven with friction alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.naming import MARGIN, evidence_beside_places
from avahazard.criticism.diagnosis.refits import refit, refit_with
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.reading import read_records
from tests.conftest import command_line

DRAG = "turbulent-drag"


@pytest.fixture(scope="module")
def observations(shared_data: Path) -> Observations:
    return build_observations(read_records([shared_data / "iseesnow-voellmy"]))


@pytest.mark.slow
def test_one_effect_more_is_never_worse(observations: Observations) -> None:
    """Its star is long and bent: the mode on it once lay where no exact table has one."""
    base = refit(observations, Specification(), {})
    wider = refit_with(base, "force:distance")
    assert wider.log_likelihood > base.log_likelihood + 30.0


@pytest.mark.parametrize(("case", "holds"), [("coulomb", False), ("voellmy", True)])
def test_drag_is_more_than_speeds_that_err_together(
    shared_data: Path, case: str, holds: bool
) -> None:
    """Peak speeds are those of the front, alike on each track: by likelihood both show drag."""
    given = build_observations(read_records([shared_data / f"iseesnow-{case}"]))
    base = refit(given, Specification(), {})
    wider = refit_with(base, DRAG)
    assert wider.evidence - base.evidence > MARGIN
    assert (evidence_beside_places(wider, DRAG) > MARGIN) is holds
    assert evidence_beside_places(base, DRAG) == np.inf


@pytest.mark.slow
def test_friction_alone_is_adequate(shared_data: Path) -> None:
    given = build_observations(read_records([shared_data / "iseesnow-coulomb"]))
    found = diagnose(given, Specification(), {})
    assert (found.result.verdict, found.result.missing) == ("adequate", ())


@pytest.mark.slow
def test_drag_is_named_alone(shared_data: Path, database: str) -> None:
    """From where `calibrate` ends: a smooth has two modes as high, of which one hides the drag."""
    run = command_line(database)
    for words in (("import", str(shared_data / "iseesnow-voellmy")), ("calibrate", "base")):
        assert run(*words).exit_code == 0
    told = json.loads(run("--json", "diagnose", "base").stdout)
    assert (told["verdict"], told["missing"]) == ("missing-effect", [DRAG])
    leader = told["candidates"][0]
    # To first order at neutral it seems to be no force at all; a short ascent shows it.
    assert leader["screened_gain"] == pytest.approx(leader["gain"], abs=1.0)
