"""Runs of hazard and zones: the same bits by every engine, taken up again, paths that fail."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import func, select

from avahazard.engine import EngineName, set_engine
from avahazard.records.errors import AvahazardError
from avahazard.results.base import plain
from avahazard.store.results import BOUNDS, latest_documents
from avahazard.store.session import reading
from avahazard.store.tables import PathResultTable, PathRunTable
from avahazard.workflow import by_path
from avahazard.workflow import hazard as hazard_module
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.hazard import hazard, run_hazard, zones
from avahazard.workflow.requests import CalibrateRequest, HazardRequest, ZonesRequest

pytestmark = pytest.mark.usefixtures("default_engine")

PATHS = ["nants", "saugy", "scey"]
ASKED: dict[str, Any] = {"return_periods": [30.0, 100.0], "paths": PATHS, "draws": 500}


@pytest.fixture(scope="module")
def model(twin_database: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    file = str(shutil.copy(twin_database, tmp_path_factory.mktemp("runs") / "model.db"))
    calibrate(file, "m", CalibrateRequest(method="gibbs", draws=100, chains=2))
    return file


@pytest.fixture
def selected(model: str, tmp_path: Path) -> str:
    return str(shutil.copy(model, tmp_path / "mine.db"))


@pytest.fixture(scope="module")
def alone(model: str, tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Any]:
    """Bounds and zones by one thread."""
    file = str(shutil.copy(model, tmp_path_factory.mktemp("alone") / "mine.db"))
    set_engine("local", workers=1)
    return plain(hazard(file, "m", HazardRequest(**ASKED)).rows), plain(
        zones(file, "m", ZonesRequest(no_drag=True, paths=PATHS)).rows
    )


@pytest.mark.parametrize(
    ("engine", "workers"),
    [
        pytest.param("local", 2, marks=pytest.mark.slow),
        ("local", 7),
        pytest.param("processes", 2, marks=pytest.mark.slow),
        pytest.param("dask", 2, marks=pytest.mark.slow),
    ],
)
def test_every_engine_gives_the_same_bits(
    selected: str, alone: tuple[Any, Any], engine: EngineName, workers: int
) -> None:
    set_engine(engine, workers=workers)
    assert plain(hazard(selected, "m", HazardRequest(**ASKED)).rows) == alone[0]
    assert plain(zones(selected, "m", ZonesRequest(no_drag=True, paths=PATHS)).rows) == alone[1]


def broken_at(
    monkeypatch: pytest.MonkeyPatch, path_id: str, error: BaseException
) -> Callable[[], None]:
    """Let the rows of one path fail; call to correct it."""
    whole = hazard_module.path_rows

    def rows(models: Any, *more: Any) -> Any:
        if models[0].path.path_id == path_id:
            raise error
        return whole(models, *more)

    monkeypatch.setattr(hazard_module, "path_rows", rows)
    return lambda: monkeypatch.setattr(hazard_module, "path_rows", whole)


def counts(database: str) -> tuple[int, int, int]:
    """Runs, finished ones, and paths of all."""
    with reading(database) as session:
        runs = session.scalar(select(func.count(PathRunTable.id)))
        finished = session.scalar(select(func.count(PathRunTable.finished)))
        paths = session.scalar(select(func.count(PathResultTable.path_id)))
    return runs or 0, finished or 0, paths or 0


def test_an_interrupted_run_goes_on_where_it_was(
    selected: str, alone: tuple[Any, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    set_engine("local", workers=1)
    monkeypatch.setattr(by_path, "BATCH", 1)
    mend = broken_at(monkeypatch, "scey", KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        run_hazard(selected, "m", HazardRequest(**ASKED))
    assert counts(selected) == (1, 0, 2)
    with reading(selected) as session:
        assert latest_documents(session, BOUNDS, "m") is None
    mend()
    broken_at(monkeypatch, "nants", AssertionError("nants is done already"))
    # Another run is none of this one's.
    other = {**ASKED, "seed": 1, "paths": ["saugy"]}
    assert not [
        n for n in run_hazard(selected, "m", HazardRequest(**other)).notes if "went on" in n
    ]
    found = run_hazard(selected, "m", HazardRequest(**ASKED))
    assert found.notes[0] == "went on where it was interrupted: 2 of 3 paths were done."
    assert plain(list(found.rows())) == alone[0]
    assert counts(selected) == (2, 2, 4)


def test_a_path_that_fails_is_told_and_the_rest_goes_on(
    selected: str, alone: tuple[Any, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    broken_at(monkeypatch, "saugy", ZeroDivisionError("no slope"))
    found = run_hazard(selected, "m", HazardRequest(**ASKED))
    reason = "ZeroDivisionError on path saugy: no slope"
    assert found.failed == {"saugy": reason}
    assert f"left out: {reason}" in found.notes
    kept = [row for row in alone[0] if row["path_id"] != "saugy"]
    assert plain(list(found.rows())) == kept
    documents = plain(list(found.documents()))
    assert [d["path_id"] for d in documents] == ["nants"] * 2 + ["saugy"] + ["scey"] * 2
    assert documents[2]["failed"] == reason
    assert documents[2]["runout_x_m"]["q50"] is None


def test_nothing_is_kept_where_all_paths_fail(
    selected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken_at(monkeypatch, "saugy", AvahazardError("It is too steep.", "Take another."))
    with pytest.raises(AvahazardError, match="too steep") as caught:
        hazard(selected, "m", HazardRequest(**{**ASKED, "paths": ["saugy"]}))
    assert caught.value.hint == "Take another."
    assert counts(selected) == (0, 0, 0)


def test_progress_tells_paths_and_rate(selected: str) -> None:
    told: list[tuple[str, float]] = []
    run_hazard(
        selected, "m", HazardRequest(**ASKED), lambda what, share: told.append((what, share))
    )
    assert told[0] == ("Runout", 0.0)
    # One more path as much every time, and some for the start of the workers.
    shares = [share for _, share in told]
    assert len(shares) == 4
    assert shares == sorted(shares)
    assert shares[2] - shares[1] == pytest.approx(1.0 / (3.0 + by_path.STARTING))
    assert shares[-1] == 1.0
    assert told[-1][0].startswith("Runout: 3 of 3 paths, ")
