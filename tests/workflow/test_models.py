"""What is stored of models."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text
from typer.testing import Result

from avahazard.records.collection import only_paths
from avahazard.records.errors import AvahazardError
from avahazard.results.base import plain
from avahazard.store import upkeep
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import add, calibrate, rerun, show_model, show_provenance
from avahazard.workflow.database import import_files
from avahazard.workflow.listing import show_models
from avahazard.workflow.requests import CalibrateRequest
from tests.conftest import command_line
from tests.criticism.lengths import as_csv, lengths
from tests.few_draws import few_draws
from tests.workflow.twin import FEW_PATHS, twin_records


def test_models_in_short_and_in_full(database: str) -> None:
    with writing(database) as session:
        save_records(session, only_paths(twin_records(), FEW_PATHS))
    assert show_models(database) == ()
    document = calibrate(database, "one", CalibrateRequest(method="gibbs", chains=2, draws=100))
    calibrate(
        database, "two", CalibrateRequest(method="metropolis", law="power", chains=2, draws=100)
    )
    one, two = show_models(database)
    assert (one.model, one.law, one.method) == ("one", "exponential", "gibbs")
    assert (two.model, two.law, two.converged) == ("two", "power", two.converged)
    shown = show_model(database, "one")
    assert shown.created == one.created
    assert shown.n_events == one.n_events
    assert one.created.endswith("Z")
    stored = plain(replace(document, next=None))
    assert shown.to_dict() == {**stored, "created": shown.created}
    with pytest.raises(AvahazardError, match="no model three") as error:
        show_model(database, "three")
    assert "one, two" in error.value.hint


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Make the models `base`, `child` of it, and `paper`."""
    folder = tmp_path_factory.mktemp("rerun")
    database, file = str(folder / "models.db"), folder / "events.csv"
    upkeep.create(database)
    file.write_text(as_csv(lengths(24, 0.3, n_columns=1)), encoding="utf-8")
    import_files(database, [file])
    calibrate(database, "base", CalibrateRequest(law="power", chains=2, draws=60, seed=5))
    calibrate(database, "paper", CalibrateRequest(law="power", method="gibbs", chains=2, draws=60))
    with few_draws():
        add(database, "base", ["covariate:column_1"], "child")
    return database


@pytest.fixture
def models(made: str, tmp_path: Path) -> str:
    """Give a database with these models."""
    return str(shutil.copy(made, tmp_path / "models.db"))


def test_every_method_gives_the_same_bits(models: str) -> None:
    for name in ("base", "child", "paper"):
        found = rerun(models, name)
        assert found.identical, name
        assert found.differences == {}
        assert found.notes == ()


@pytest.mark.slow
def test_another_seed_is_told(models: str) -> None:
    engine = create_engine(f"sqlite:///{models}")
    with engine.begin() as connection:
        connection.execute(
            text(
                "UPDATE calibrations SET result = json_set(result, '$.seed', 6) "
                "WHERE model = 'base'"
            )
        )
    engine.dispose()
    found = rerun(models, "base")
    assert not found.identical
    assert {"alpha", "beta", "sigma"} <= set(found.differences)
    assert found.differences["alpha"].largest > 0.0
    run: Callable[..., Result] = command_line(models)
    assert "not identical" in run("rerun", "base").stdout


@pytest.mark.slow
def test_changed_records_are_refused(models: str, tmp_path: Path) -> None:
    file = tmp_path / "events.csv"
    file.write_text("event_id,fall_height_m,runout_length_m\nnew,500,900\n", encoding="utf-8")
    import_files(models, [file])
    assert show_provenance(models, "base").records_changed
    with pytest.raises(AvahazardError, match="have changed"):
        rerun(models, "base")


def test_provenance(models: str) -> None:
    run = command_line(models)
    found = json.loads(run("--json", "model", "child", "--provenance").stdout)
    assert (found["parent"], found["seed"], found["draws"]) == ("base", 5, 60)
    assert found["specification"]["law"] == "power"
    assert found["made_with"] == found["now"]
    assert found["now"]["versions"].keys() >= {"avahazard", "numpy", "scipy", "numba"}
    assert len(found["now"]["lock_sha256"]) == 64
    shown = run("model", "child", "--provenance").stdout
    assert "Provenance of child" in shown
    assert max(map(len, shown.splitlines())) <= 80
    assert "identical" in run("rerun", "paper").stdout
