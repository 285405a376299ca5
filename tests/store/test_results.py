"""Comparisons, diagnoses, bounds and zones in every kind of database."""

from __future__ import annotations

from typing import Any

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.models import save_model
from avahazard.store.path_results import BOUNDS, ZONES, latest_documents
from avahazard.store.results import COMPARISON, DIAGNOSIS, Kind, latest_result, save_result
from avahazard.store.session import reading, writing
from tests.store.documents import save_documents


def test_the_latest_results_come_back(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "m", {})
        assert latest_result(session, COMPARISON, "m") is None
        assert latest_result(session, DIAGNOSIS, "m") is None
        assert latest_documents(session, BOUNDS, "m") is None
        assert latest_documents(session, ZONES, "m") is None
        for value in (1.0, 2.0):
            save_result(session, COMPARISON, "m", {"rmse_m": value, "bias_m": float("nan")})
            save_result(session, DIAGNOSIS, "m", {"detectable_m": value, "missing": []})
            save_documents(session, BOUNDS, "m", [{"path_id": "P", "mean": value}])
            save_documents(session, ZONES, "m", [{"path_id": "P", "beyond": value}])
    with reading(any_database) as session:
        assert latest_result(session, COMPARISON, "m") == {"rmse_m": 2.0, "bias_m": None}
        assert latest_result(session, DIAGNOSIS, "m") == {"detectable_m": 2.0, "missing": []}
        assert latest_documents(session, BOUNDS, "m") == [{"path_id": "P", "mean": 2.0}]
        assert latest_documents(session, ZONES, "m") == [{"path_id": "P", "beyond": 2.0}]


@pytest.mark.parametrize("kind", [COMPARISON, DIAGNOSIS, BOUNDS, ZONES])
def test_results_belong_to_a_model(kind: Kind[Any], database: str) -> None:
    with writing(database) as session, pytest.raises(AvahazardError, match="no model"):
        save_result(session, kind, "m", {})
