"""Calibrations in every kind of database."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.calibrations import latest_calibration, save_calibration
from avahazard.store.draws import load_draws
from avahazard.store.models import save_model
from avahazard.store.session import reading, writing


def test_the_latest_comes_back_with_its_draws(any_database: str) -> None:
    draws = {"a": np.array([[0.1 + 0.2, 1.0]]), "sigma": np.array([[5e-324, -0.5]])}
    with writing(any_database) as session:
        save_model(session, "m", {})
        for seed in (1, 2**62):
            save_calibration(
                session,
                "m",
                settings={"chains": np.int64(1)},
                seed=seed,
                data_fingerprint="f" * 64,
                diagnostics={"rhat_max": float("nan"), "ess_bulk_min": 7.5},
                converged=bool(seed == 1),
                result={"model": "m", "parameters": {"a": {"mean": np.float64(0.5)}}},
                draws=draws,
            )
    with reading(any_database) as session:
        found = latest_calibration(session, "m")
        back = load_draws(session, found.id)
    assert (found.seed, found.converged, found.settings) == (2**62, False, {"chains": 1})
    assert found.diagnostics == {"rhat_max": None, "ess_bulk_min": 7.5}
    assert found.result["parameters"]["a"]["mean"] == 0.5
    assert back.keys() == draws.keys()
    for name, values in draws.items():
        np.testing.assert_array_equal(back[name], values)


def test_a_missing_model_or_calibration_is_said(database: str) -> None:
    with writing(database) as session:
        with pytest.raises(AvahazardError, match="no model m"):
            latest_calibration(session, "m")
        save_model(session, "m", {})
        with pytest.raises(AvahazardError, match="no calibration"):
            latest_calibration(session, "m")
