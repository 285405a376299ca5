"""The command line on the twin, and on the twin with models."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.requests import CalibrateRequest
from tests.conftest import command_line
from tests.once import made_once


@pytest.fixture
def on_twin(twin_database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on the twin."""
    return command_line(twin_database)


@pytest.fixture
def document(on_twin: Callable[..., Result]) -> Callable[..., Any]:
    """Give a function that runs the command line on the twin and reads its JSON."""

    def run(*words: str) -> Any:
        done = on_twin("--json", *words)
        assert done.exit_code == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def model_database(twin_database: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin and the models `base` and `plain`; do not write to it."""

    def make(folder: Path) -> None:
        file = str(shutil.copy(twin_database, folder / "twin.db"))
        calibrate(file, "base", CalibrateRequest(chains=2, draws=500))
        calibrate(file, "plain", CalibrateRequest(method="gibbs"))

    return str(made_once(tmp_path_factory, "models", make) / "twin.db")


@pytest.fixture
def on_models(model_database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on the database with models."""
    return command_line(model_database)


@pytest.fixture
def on_my_models(model_database: str, tmp_path: Path) -> Callable[..., Result]:
    """Give a function that runs the command line on a copy of the database with models."""
    return command_line(shutil.copy(model_database, tmp_path / "mine.db"))
