"""Laws fitted to records of known laws."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.fit import fit_laws
from tests.telling import untold


def _straight(volume: np.ndarray, mu: np.ndarray) -> Records:
    return Records(
        events=tuple(
            Event(str(i), fall_height_m=1000.0 * m, runout_length_m=1000.0, volume_m3=v)
            for i, (v, m) in enumerate(zip(volume, mu, strict=True))
        )
    )


def test_a_law_is_given_back_and_leads(database: str) -> None:
    volume = np.geomspace(1e3, 1e6, 30)
    mu = 1.07 * volume**-0.065
    with writing(database) as session:
        save_records(session, _straight(volume, mu))
    found = fit_laws(database)
    fits = {entry.law: entry for entry in found.rows}
    assert fits["power"].parameters["alpha"].value == pytest.approx(1.07)
    assert fits["power"].parameters["beta"].value == pytest.approx(0.065)
    assert fits["exponential"].parameters["n"].unit == "1/m3"
    assert min(fits.values(), key=lambda entry: entry.aic).law == "power"
    # A power law fixes no volume at which friction bends.
    assert "rational" not in fits
    assert any("rational" in note for note in found.notes)


def test_events_without_a_volume_are_counted(database: str) -> None:
    volume = np.array([1e3, 1e4, 1e5, 2e5])
    records = _straight(volume, np.array([0.5, 0.45, 0.4, 0.42]))
    bare = Event("bare", fall_height_m=500.0, runout_length_m=900.0)
    with writing(database) as session:
        save_records(session, Records(events=(*records.events, bare)))
    found = fit_laws(database)
    assert {entry.n_events for entry in found.rows} == {4}
    assert untold(found.notes[-1], 1, 5) == []


def test_no_volume_at_all(database: str) -> None:
    bare = Event("bare", fall_height_m=500.0, runout_length_m=900.0)
    with writing(database) as session:
        save_records(session, Records(events=(bare,)))
    with pytest.raises(AvahazardError, match="there are none"):
        fit_laws(database)
