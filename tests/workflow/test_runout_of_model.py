"""Runs by a stored model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.inference.model.laws import LAWS
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.store import upkeep
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.runout import run_path
from avahazard.workflow.runout_of_model import run_model
from avahazard.workflow.stored_model import load_stored
from tests.workflow.twin import FEW_PATHS, twin_records


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin and some models; do not write to it."""
    file = str(Path(tmp_path_factory.mktemp("models")) / "models.db")
    upkeep.create(file)
    with writing(file) as session:
        save_records(session, twin_records())
    few = {"paths": FEW_PATHS, "chains": 2, "draws": 60}
    calibrate(file, "plain", **few)
    calibrate(file, "normal", **few, law="power", distribution="normal", without=["centrifugal"])
    calibrate(file, "drag", **few, law="constant", with_=["turbulent-drag"])
    calibrate(file, "paths", with_=["path-effect"], chains=2, draws=60)
    calibrate(file, "gibbs", method="gibbs", chains=2, draws=60)
    return file


@pytest.mark.parametrize(("name", "law"), [("plain", "exponential"), ("gibbs", "exponential")])
def test_friction_is_the_median_over_the_posterior(models: str, name: str, law: str) -> None:
    document = run_model(models, "scey", name, volume_m3=2e4)
    model = load_stored(models, name).model
    u = model.draws[:, :2]
    expected = np.median(np.exp(LAWS[law].log_friction(u, np.array([2e4]))))
    assert document["mu"] == pytest.approx(expected, rel=1e-12)
    assert document["mu_from"] == "posterior median"
    plain = run_path(models, "scey", document["mu"])
    assert document["runout_x_m"] == plain["runout_x_m"]
    assert document["speeds"] == plain["speeds"]
    assert (document["model"], document["volume_m3"], document["notes"]) == (name, 2e4, [])


def test_normal_friction_without_centrifugal(models: str) -> None:
    document = run_model(models, "scey", "normal", volume_m3=2e4)
    model = load_stored(models, "normal").model
    natural = LAWS["power"].to_natural(model.draws[:, :2])
    assert document["mu"] == pytest.approx(np.median(natural[:, 0] * 2e4 ** -natural[:, 1]))
    # Without the load of curvature the block runs further at the same friction.
    curved = run_path(models, "scey", document["mu"])
    assert document["runout_x_m"] > curved["runout_x_m"] + 20.0


def test_a_path_has_its_own_friction(models: str) -> None:
    model = load_stored(models, "paths").model
    base = np.exp(model.draws[:, 0] - model.draws[:, 1] * 0.02)
    for path_id in ("scey", "saugy"):
        document = run_model(models, path_id, "paths", volume_m3=2e4)
        expected = np.median(base * np.exp(model.offsets[path_id]))
        assert document["mu"] == pytest.approx(expected)


def test_an_effect_on_the_motion_acts(models: str) -> None:
    document = run_model(models, "scey", "drag", volume_m3=None, mu=0.45)
    plain = run_path(models, "scey", 0.45)
    assert document["mu_from"] == "given"
    assert document["speed_max_m_s"] < plain["speed_max_m_s"]
    assert document["runout_x_m"] < plain["runout_x_m"]


def test_a_path_that_the_model_does_not_know(models: str) -> None:
    document = run_model(models, "gurraz", "plain", volume_m3=2e4)
    assert document["mu"] == run_model(models, "scey", "plain", volume_m3=2e4)["mu"]


@pytest.mark.parametrize("volume", [None, 0.0, -5.0, float("nan")])
def test_neither_friction_nor_volume(models: str, volume: float | None) -> None:
    with pytest.raises(AvahazardError, match="volume must be"):
        run_model(models, "scey", "plain", volume_m3=volume)


def test_records_that_changed_are_noted(database: str) -> None:
    with writing(database) as session:
        save_records(session, twin_records())
    calibrate(database, "m", method="gibbs", chains=2, draws=60)
    with writing(database) as session:
        new = Event("new", "scey", runout_elevation_m=1100.0, volume_m3=1e4)
        save_records(session, Records(events=(new,)))
    assert "have changed" in run_model(database, "scey", "m", volume_m3=1e4)["notes"][0]
