"""Calibrate, compare and diagnose: the same bits by every engine."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from avahazard.engine import EngineName, set_engine
from avahazard.inference.likelihood import posterior
from avahazard.inference.model import observations
from avahazard.store import upkeep
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.synth.making import make_dataset
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from avahazard.workflow.stored import load_parameter_draws

pytestmark = pytest.mark.usefixtures("default_engine")


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A database with 24 events on three paths, drag at work, some with speeds."""
    file = str(tmp_path_factory.mktemp("engines") / "world.db")
    upkeep.create(file)
    records, _ = make_dataset(5, 24, 3, {"turbulent-drag": 1.0})
    with writing(file) as session:
        save_records(session, records)
    return file


def answers(world: str, folder: Path, engine: EngineName, workers: int) -> dict[str, Any]:
    """What the commands give by an engine, to the last bit."""
    folder.mkdir()
    file = str(shutil.copy(world, folder / "mine.db"))
    set_engine(engine, workers=workers)
    found = {
        "calibrate": calibrate(
            file, "m", CalibrateRequest(with_=["turbulent-drag"], chains=2, draws=60)
        ).to_dict(),
        "compare": compare(file, "m").to_dict(),
        "draws": {key: draws.tolist() for key, draws in load_parameter_draws(file, "m").items()},
    }
    calibrate(file, "plain", CalibrateRequest(chains=2, draws=60))
    diagnosis = diagnose_model(file, "plain", DiagnoseRequest(seed=2))
    return {**found, "diagnose": diagnosis.to_dict()}


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "workers"), [("local", 2), ("processes", 2), ("dask", 2)])
def test_every_engine_gives_the_same_bits(
    world: str, tmp_path: Path, alone: dict[str, Any], engine: EngineName, workers: int
) -> None:
    found = answers(world, tmp_path / engine, engine, workers)
    for command, document in alone.items():
        assert found[command] == document, command


@pytest.fixture(scope="module")
def alone(world: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The answers of one thread."""
    return answers(world, tmp_path_factory.mktemp("one") / "thread", "local", 1)


def test_a_calibration_is_the_same_by_threads_and_with_grounds_of_other_processes(
    world: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(observations, "MANY_PATHS", 1)
    monkeypatch.setattr(posterior, "WORTH_SHARING", 0)
    made = []
    for engine, workers in (("local", 1), ("local", 7), ("processes", 2)):
        file = str(shutil.copy(world, tmp_path / f"{engine}-{workers}.db"))
        set_engine(engine, workers=workers)  # type: ignore[arg-type]
        found = calibrate(file, "m", CalibrateRequest(chains=2, draws=50)).to_dict()
        draws = {key: values.tolist() for key, values in load_parameter_draws(file, "m").items()}
        made.append((found, draws))
    assert made[1:] == made[:1] * 2
