"""Calibration by the marginal method, and what is stored of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.reading import read_records
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.models import show_models
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored import load_stored
from tests.workflow.twin import FEW_PATHS, twin_records

FEW: dict[str, Any] = {"paths": FEW_PATHS, "chains": 2, "draws": 100}


def test_the_stored_model_is_the_one_that_is_told(my_twin: str) -> None:
    told: list[float] = []
    found = calibrate(
        my_twin,
        "m",
        CalibrateRequest(**FEW, seed=3),
        lambda _what, done, total: told.append(done / total),
    )
    stored, records = load_stored(my_twin, "m")
    assert stored.calibration == found
    assert stored.paths == FEW_PATHS
    assert len(records.events) == 173
    assert found.n_events == 61
    u = stored.draws
    assert found.parameters["a"].mean == pytest.approx(np.exp(u[:, 0]).mean())
    assert found.parameters["sigma"].q95 == pytest.approx(np.quantile(np.exp(u[:, 2]), 0.95))
    assert (told[0], told[-1]) == (0.0, 1.0)


def test_equal_seeds_equal_bits(my_twin: str) -> None:
    short = {**FEW, "draws": 60}
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        calibrate(my_twin, name, CalibrateRequest(**short, seed=seed))
    a, b, c = (load_stored(my_twin, name)[0] for name in "abc")
    np.testing.assert_array_equal(a.draws, b.draws)
    assert a.calibration.parameters == b.calibration.parameters
    assert not np.array_equal(a.draws, c.draws)


def test_a_run_too_short_is_stored_as_such(my_twin: str) -> None:
    found = calibrate(my_twin, "short", CalibrateRequest(paths=["scey"], chains=2, draws=50))
    assert found.diagnostics.converged is False
    assert "not converged" in found.notes[-1]
    assert show_models(my_twin)[0].converged is False


def test_path_offsets_are_told_and_kept(my_twin: str) -> None:
    found = calibrate(my_twin, "m", CalibrateRequest(with_=["path-effect"], chains=2, draws=60))
    offsets = {k for k in found.parameters if k.startswith("path:")}
    assert offsets == {f"path:{p.path_id}" for p in twin_records().paths}
    stored, _ = load_stored(my_twin, "m")
    assert stored.offsets["scey"].shape == (120,)
    assert found.parameters["path:scey"].mean == pytest.approx(stored.offsets["scey"].mean())
    assert found.effects == ("path-effect",)


def test_without_centrifugal(my_twin: str) -> None:
    found = calibrate(my_twin, "m", CalibrateRequest(**FEW, without=["centrifugal"]))
    assert found.centrifugal is False
    assert load_stored(my_twin, "m")[0].specification.centrifugal is False
    # Curvature loads the bed of these hollow paths: without, more friction is needed.
    base = calibrate(my_twin, "base", CalibrateRequest(**FEW))
    assert found.parameters["a"].mean > base.parameters["a"].mean + 0.02


def test_an_effect_asked_for_and_away_is_not_there(my_twin: str) -> None:
    found = calibrate(my_twin, "m", CalibrateRequest(**FEW, with_=["season"], without=["season"]))
    assert found.effects == ()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"without": ["season"]}, "does not have the effect 'season'"),
        ({"without": ["ghosts"]}, "no effect 'ghosts'"),
        ({"with_": ["ghosts"]}, "no effect 'ghosts'"),
        ({"with_": ["path-effect"], "paths": FEW_PATHS}, "3 paths, fewer than 5"),
        ({"paths": ["nowhere"]}, "no path 'nowhere'"),
        ({"method": "gibbs", "with_": ["season"]}, "gibbs does not work with the effect season"),
    ],
)
def test_what_cannot_be_calibrated_leaves_nothing_behind(my_twin: str, asked, message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        calibrate(my_twin, "m", CalibrateRequest(**asked))
    assert show_models(my_twin) == ()


def test_a_taken_name_is_refused_before_computing(my_twin: str, monkeypatch) -> None:
    calibrate(my_twin, "m", CalibrateRequest(**FEW, method="gibbs"))
    monkeypatch.setattr("avahazard.workflow.calibrate.build_observations", None)
    with pytest.raises(AvahazardError, match="a model m already"):
        calibrate(my_twin, "m", CalibrateRequest(**FEW))


def test_volumes_are_needed_where_they_act(database: str) -> None:
    events = tuple(
        Event(f"E{k}", fall_height_m=500.0, runout_length_m=1000.0 + k) for k in range(30)
    )
    with writing(database) as session:
        save_records(session, Records(events=events))
    with pytest.raises(AvahazardError, match="exponential") as error:
        calibrate(database, "m", CalibrateRequest())
    assert "constant" in error.value.hint
    with pytest.raises(AvahazardError, match="volume-scatter"):
        calibrate(database, "m", CalibrateRequest(law="constant", scatter="volume"))
    found = calibrate(database, "m", CalibrateRequest(law="constant", chains=2, draws=50))
    assert 0.48 < found.parameters["a"].mean < 0.5


def test_rock_avalanches_fall_as_published(database: str, shared_data: Path) -> None:
    with writing(database) as session:
        save_records(session, read_records([shared_data / "rock-avalanches-canada"]))
    for method in ("marginal", "gibbs"):
        found = calibrate(
            database, method, CalibrateRequest(law="power", method=method, chains=2, draws=500)
        )  # type: ignore[arg-type]
        beta = found.parameters["beta"]
        assert beta.mean == pytest.approx(0.085, abs=0.01)
        assert beta.q05 > 0.0


def test_sensor_tracks_with_the_constant_law(database: str, shared_data: Path) -> None:
    with writing(database) as session:
        save_records(session, read_records([shared_data / "avanodes"]))
    found = calibrate(database, "m", CalibrateRequest(law="constant", chains=2, draws=150))
    parameters = found.parameters
    assert 0.4 < parameters["a"].mean < 0.8
    # The force on these tracks is far from that of one friction all along.
    assert 0.1 < parameters["track_sigma"].mean < 0.4
    assert parameters["track_sigma"].unit == "friction"
