"""Inventories as they were published, with a mapping, through the whole loop."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from avahazard.records.mapping import BESIDE
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest, ImportRequest

PUBLISHED = Path(os.environ.get("AVAHAZARD_PUBLISHED", Path(__file__).parents[3] / "shared/data"))
GIANT = "giant_landslides_v12_2018.xlsx"
MAPPING = """sheet = "List1"
header = 2
need = ["V (km3)"]
keep = ["Type", "Archipelago", "H/L", "L/H", "Completnes"]
[columns]
event_id = "Name"
fall_height_m = "DeltaH"
runout_length_m = {from = "Length", unit = "km"}
volume_m3 = {from = "V (km3)", unit = "km3"}
"""


@pytest.mark.slow
def test_giant_landslides_go_through_the_loop(tmp_path: Path, database: str) -> None:
    found = sorted(PUBLISHED.rglob(GIANT))
    if not found:
        pytest.skip("the published workbook is not there: AVAHAZARD_PUBLISHED names its folder")
    columns = tmp_path / BESIDE
    columns.write_text(MAPPING, encoding="utf-8")
    assert len(MAPPING.splitlines()) <= 15
    read = import_files(database, found[:1], ImportRequest(columns=str(columns), unusual=True))
    assert read.records.events.new == 63
    model = calibrate(database, "base", CalibrateRequest(chains=2, draws=200, seed=1, law="power"))
    outcome = [note for note in model.notes if note.key == "outcome_column"]
    assert {note.values["column"] for note in outcome} == {"H/L", "L/H"}
    compared = compare(database, "base")
    assert np.isfinite(compared.scores.elpd_loo)
    told = diagnose_model(database, "base", DiagnoseRequest())
    assert told.candidates
    assert not {"covariate:H/L", "covariate:L/H"} & {c.effect for c in told.candidates}
    best = next(c.effect for c in told.candidates if not c.effect.startswith(("force:", "two-")))
    child = add(database, "base", [best], "more")
    assert child.effects
