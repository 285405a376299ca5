"""Volumes that no avalanche has: nothing overflows, and nothing ends in a traceback."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.model.laws import LAWS
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.friction import fit_laws
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from tests.criticism.lengths import lengths

pytestmark = pytest.mark.usefixtures("drawn_little")


@pytest.fixture(params=[pytest.param("one", marks=pytest.mark.slow), "all"])
def wild_database(request: pytest.FixtureRequest, database: str) -> str:
    """Give a database with events of which one, or all, have volumes off the scale."""
    records = lengths(16, n_columns=1)
    powers = np.random.default_rng(0).uniform(-319.0, 307.0, 16)
    wild = {0: 1e308, 1: 1e-320} if request.param == "one" else dict(enumerate(10.0**powers))
    events = [
        replace(event, volume_m3=float(wild.get(i, event.volume_m3 or 0.0)))
        for i, event in enumerate(records.events)
    ]
    # An import refuses them; a database of before may hold them.
    with writing(database) as session:
        save_records(session, Records(events=tuple(events)))
    return database


def test_laws_are_fitted_and_calibrated(wild_database: str) -> None:
    assert "constant" in [row.law for row in fit_laws(wild_database).rows]
    for name in LAWS:
        found = calibrate(wild_database, name, CalibrateRequest(law=name, chains=2, draws=50))
        assert all(np.isfinite([p.mean, p.sd]).all() for p in found.parameters.values())
    with pytest.raises(AvahazardError, match="gibbs cannot calculate"):
        calibrate(wild_database, "paper", CalibrateRequest(method="gibbs"))


def test_they_are_diagnosed(wild_database: str) -> None:
    calibrate(wild_database, "power", CalibrateRequest(law="power", chains=2, draws=50))
    assert diagnose_model(wild_database, "power", DiagnoseRequest()).candidates


@pytest.mark.slow
@pytest.mark.parametrize("largest", [1e-3, 1e3, 1e8, 1e14])
def test_the_unit_of_volume_does_not_matter(database: str, largest: float) -> None:
    records = lengths(24)
    most = max(event.volume_m3 or 0.0 for event in records.events)
    events = [
        replace(event, volume_m3=(event.volume_m3 or most) * largest / most)
        for event in records.events
    ]
    with writing(database) as session:
        save_records(session, Records(events=tuple(events)))
    request = CalibrateRequest(chains=2, draws=100, seed=1)
    found = calibrate(database, "base", request)
    assert all(np.isfinite([p.mean, p.sd]).all() for p in found.parameters.values())
    compared = compare(database, "base")
    assert compared.held_out is not None
    assert np.isfinite(compared.scores.elpd_loo)
