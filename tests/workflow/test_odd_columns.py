"""Columns that hide an effect or seem to be one: what the diagnosis names on inputs that failed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest, ImportRequest

INPUTS = Path(os.environ.get("AVAHAZARD_INPUTS", Path(__file__).parents[3] / "shared/data/inputs"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "unknown", "named"),
    [
        ("04-sentinel-in-own-column/covblank.csv", (), "covariate:mean_slope_deg"),
        ("04-sentinel-in-own-column/covm999.csv", ("-9999",), "covariate:mean_slope_deg"),
        ("05-angle-of-reach-column/m_a_angle.csv", (), "volume-law"),
        ("05-angle-of-reach-column/m_a_none.csv", (), "volume-law"),
    ],
)
def test_the_true_effect_is_named(
    database: str, file: str, unknown: tuple[str, ...], named: str
) -> None:
    if not INPUTS.is_dir():
        pytest.skip("the inputs that are not part of the repository are not there")
    import_files(database, [INPUTS / file], ImportRequest(unknown=unknown))
    calibrate(database, "b", CalibrateRequest(seed=1))
    told = diagnose_model(database, "b", DiagnoseRequest())
    assert told.verdict != "adequate"
    assert list(told.missing) == [named]
