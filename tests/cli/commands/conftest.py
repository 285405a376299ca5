"""The twin, imported once for the commands that only read."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from avahazard.store import upkeep
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.import_files import import_files
from tests.conftest import command_line
from tests.once import made_once

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(sys.executable).with_name("avahazard")


def make_twin(folder: Path) -> str:
    """Make a database with the twin."""
    file = str(folder / "twin.db")
    upkeep.create(file)
    import_files(file, [ROOT / "data"])
    return file


@pytest.fixture(scope="session")
def twin_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin; do not write to it."""
    return str(made_once(tmp_path_factory, "twin", make_twin) / "twin.db")


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
def model_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin and the models `base` and `plain`; do not write to it."""

    def make(folder: Path) -> None:
        file = make_twin(folder)
        calibrate(file, "base")
        calibrate(file, "plain", method="gibbs")

    return str(made_once(tmp_path_factory, "models", make) / "twin.db")


@pytest.fixture
def on_models(model_database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on the database with models."""
    return command_line(model_database)


@pytest.fixture
def on_my_models(model_database: str, tmp_path: Path) -> Callable[..., Result]:
    """Give a function that runs the command line on a copy of the database with models."""
    return command_line(shutil.copy(model_database, tmp_path / "mine.db"))
