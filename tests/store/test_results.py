"""Comparisons, diagnoses, bounds and zones in every kind of database."""

from __future__ import annotations

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.comparisons import latest_comparison, save_comparison
from avahazard.store.diagnoses import latest_diagnosis, save_diagnosis
from avahazard.store.hazard import latest_hazard, save_hazard
from avahazard.store.models import save_model
from avahazard.store.session import reading, writing
from avahazard.store.zones import latest_zones, save_zones


def test_the_latest_results_come_back(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "m", {})
        assert latest_comparison(session, "m") is None
        assert latest_diagnosis(session, "m") is None
        assert latest_hazard(session, "m") is None
        assert latest_zones(session, "m") is None
        for value in (1.0, 2.0):
            save_comparison(session, "m", {"rmse_m": value, "bias_m": float("nan")})
            save_diagnosis(session, "m", {"detectable_m": value, "missing": []})
            save_hazard(session, "m", [{"path_id": "P", "mean": value}])
            save_zones(session, "m", [{"path_id": "P", "beyond": value}])
    with reading(any_database) as session:
        assert latest_comparison(session, "m") == {"rmse_m": 2.0, "bias_m": None}
        assert latest_diagnosis(session, "m") == {"detectable_m": 2.0, "missing": []}
        assert latest_hazard(session, "m") == [{"path_id": "P", "mean": 2.0}]
        assert latest_zones(session, "m") == [{"path_id": "P", "beyond": 2.0}]


def test_results_belong_to_a_model(database: str) -> None:
    with writing(database) as session:
        with pytest.raises(AvahazardError, match="no model"):
            save_comparison(session, "m", {})
        with pytest.raises(AvahazardError, match="no model"):
            save_diagnosis(session, "m", {})
        with pytest.raises(AvahazardError, match="no model"):
            save_hazard(session, "m", [])
        with pytest.raises(AvahazardError, match="no model"):
            save_zones(session, "m", [])
