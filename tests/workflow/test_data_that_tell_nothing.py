"""Records that tell next to nothing: numbers stay numbers, and the prior is called what it is."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from avahazard.records.collection import Event
from avahazard.records.errors import AvahazardError
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.friction import fit_laws
from avahazard.workflow.hazard import hazard
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest, HazardRequest
from tests.workflow.worlds import bowl, known_stops


@pytest.mark.slow
def test_the_prior_is_called_what_it_is(database: str) -> None:
    prior = {"log a", "log sigma"}
    events = tuple(
        replace(event, runout_sigma_m=5000.0, volume_m3=1e4 * (k + 1))
        for k, event in enumerate(known_stops())
    )
    with writing(database) as session:
        save_records(session, bowl(events=events))
    found = calibrate(database, "m", CalibrateRequest(chains=2, draws=300, seed=2))
    for summary in found.parameters.values():
        assert all(math.isfinite(v) for v in (summary.mean, summary.sd, summary.mode))
    dominated = [note for note in found.notes if note.key == "prior_dominated"]
    told = {note.values["parameter"] for note in dominated}
    assert prior <= told
    for name in prior:
        assert any(
            f"{name} is weakly identified: in m it is prior-dominated" in note
            for note in found.notes
        )
    for row in hazard(database, "m", HazardRequest(volumes=[2e4], draws=500)).rows:
        assert prior <= {
            k for k in told if any(f"{k} is weakly identified" in note for note in row.notes)
        }


def test_least_squares_of_equal_volumes_say_so(database: str) -> None:
    with writing(database) as session:
        save_records(session, bowl(events=known_stops(volume_m3=3e4, volume_rel_sigma=0.01)))
    found = fit_laws(database)
    for row in found.rows:
        assert all(math.isfinite(p.value) and abs(p.value) < 10 for p in row.parameters.values())
    assert any("all volumes are equal" in note for note in found.notes)


def test_effects_are_not_sought_where_nothing_stopped(database: str) -> None:
    events = tuple(Event(f"e{k}", "B", left_profile=True) for k in range(3))
    with writing(database) as session:
        save_records(session, bowl(events=events))
    calibrate(database, "m", CalibrateRequest(law="constant", chains=2, draws=50))
    with pytest.raises(AvahazardError, match="Every event of m ran beyond its profile") as told:
        diagnose_model(database, "m", DiagnoseRequest())
    assert "skip" in (told.value.hint or "")
