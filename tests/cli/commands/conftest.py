"""The twin, imported once for the commands that only read."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from avahazard.store import upkeep
from avahazard.workflow.import_files import import_files
from tests.conftest import command_line

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(sys.executable).with_name("avahazard")


@pytest.fixture(scope="session")
def twin_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin; do not write to it."""
    file = str(tmp_path_factory.mktemp("twin") / "twin.db")
    upkeep.create(file)
    import_files(file, [ROOT / "data"])
    return file


@pytest.fixture
def on_twin(twin_database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on the twin."""
    return command_line(twin_database)


@pytest.fixture
def installed(twin_database: str) -> Callable[..., Any]:
    """Give a function that runs the installed command on the twin and reads its JSON."""

    def run(*words: str) -> Any:
        done = subprocess.run(
            [PROGRAM, "--db", twin_database, "--json", *words],
            check=True,
            capture_output=True,
            text=True,
        )
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def model_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin and the models `base` and `plain`; do not write to it."""
    file = str(tmp_path_factory.mktemp("models") / "models.db")
    upkeep.create(file)
    import_files(file, [ROOT / "data"])
    for words in (["base"], ["plain", "--method", "gibbs"]):
        subprocess.run([PROGRAM, "--db", file, "calibrate", *words], check=True)
    return file


@pytest.fixture
def on_models(model_database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on the database with models."""
    return command_line(model_database)


@pytest.fixture
def on_my_models(model_database: str, tmp_path: Path) -> Callable[..., Result]:
    """Give a function that runs the command line on a copy of the database with models."""
    return command_line(shutil.copy(model_database, tmp_path / "mine.db"))
