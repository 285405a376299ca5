"""A law that is added to `LAWS`, and to nothing else, works in every command."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from avahazard.inference.model.laws import LAWS
from avahazard.records.errors import AvahazardError
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.friction import fit_laws
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored import load_stored
from tests.criticism.lengths import as_csv, lengths
from tests.inference.new_law import NAME, halving


@pytest.fixture
def database_with_law(
    database: str, write: Callable[[str, str], Path], monkeypatch: pytest.MonkeyPatch
) -> str:
    """Give a database with events, in a program that has one law more."""
    monkeypatch.setitem(LAWS, NAME, halving())
    import_files(database, [write("events.csv", as_csv(lengths(40, 0.1, n_columns=1)))])
    return database


def test_it_is_calibrated_and_fitted(database_with_law: str) -> None:
    found = calibrate(database_with_law, "m", CalibrateRequest(law=NAME, chains=2, draws=60))
    assert found.law == NAME
    assert {"a", "c", "sigma"} == found.parameters.keys()
    assert found.parameters["c"].unit == "m3"
    fits = {entry.law: entry for entry in fit_laws(database_with_law).rows}
    assert fits[NAME].parameters.keys() == {"a", "c"}


@pytest.mark.parametrize(("uses_volume", "ignored"), [(False, True), (True, False)])
def test_one_without_volume_gives_one_runout_for_all_volumes(
    database_with_law: str, monkeypatch: pytest.MonkeyPatch, uses_volume: bool, ignored: bool
) -> None:
    same = replace(LAWS["constant"], name="even", uses_volume=uses_volume)
    monkeypatch.setitem(LAWS, "even", same)
    calibrate(database_with_law, "m", CalibrateRequest(law="even", chains=2, draws=50))
    assert load_stored(database_with_law, "m")[0].ignores_volume == ignored


@pytest.mark.parametrize("method", ["gibbs", "metropolis"])
def test_the_papers_samplers_refuse_what_they_cannot_do(
    database_with_law: str, method: str
) -> None:
    with pytest.raises(AvahazardError, match=NAME):
        calibrate(database_with_law, "m", CalibrateRequest(law=NAME, method=method))
