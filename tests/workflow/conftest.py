"""The twin with small models of every kind."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from avahazard.engines.com1dfa import PLACE
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.requests import CalibrateRequest
from tests.once import made_once
from tests.workflow.slope import make_slope
from tests.workflow.twin import FEW_PATHS


@pytest.fixture(scope="session")
def twin_models(twin_database: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin and some models; do not write to it."""

    def make(folder: Path) -> None:
        file = str(shutil.copy(twin_database, folder / "models.db"))
        short: dict[str, Any] = {"chains": 2, "draws": 60}
        few: dict[str, Any] = {"paths": FEW_PATHS, **short}
        calibrate(file, "plain", CalibrateRequest(**few))
        calibrate(
            file,
            "normal",
            CalibrateRequest(**few, law="power", distribution="normal", without=["centrifugal"]),
        )
        calibrate(file, "drag", CalibrateRequest(**few, law="constant", with_=["turbulent-drag"]))
        calibrate(file, "paths", CalibrateRequest(with_=["path-effect"], **short))
        calibrate(file, "gibbs", CalibrateRequest(method="gibbs", **short))

    return str(made_once(tmp_path_factory, "twin-models", make) / "models.db")


@pytest.fixture(scope="session")
def flow_made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a database of runs and a model calibrated on them; do not write to it."""
    return made_once(tmp_path_factory, "simulated-slope", make_slope)


@pytest.fixture
def flow_slope(flow_made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a copy of it."""
    monkeypatch.setenv(PLACE, str(flow_made / "python"))
    return Path(shutil.copytree(flow_made, tmp_path / "slope"))
