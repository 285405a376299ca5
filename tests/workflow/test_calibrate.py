"""Calibration by the marginal method, and what is stored of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.effects.own_file import TEMPLATE
from avahazard.records.collection import Event, Records
from avahazard.records.errors import AvahazardError
from avahazard.records.reading import read_records
from avahazard.store.records import save_records
from avahazard.store.results import COMPARISON, latest_result, list_models, load_model
from avahazard.store.session import reading, writing
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare, ladder, predict
from avahazard.workflow.effects import own_effects
from avahazard.workflow.listing import show_models
from avahazard.workflow.path import run_block
from avahazard.workflow.requests import CalibrateRequest, RunoutRequest
from avahazard.workflow.stored import load_stored
from tests.store.documents import save_bare
from tests.workflow.twin import FEW_PATHS, twin_records

FEW: dict[str, Any] = {"paths": FEW_PATHS, "chains": 2, "draws": 100}


def test_the_stored_model_is_the_one_that_is_told(my_twin: str) -> None:
    told: list[float] = []
    found = calibrate(
        my_twin, "m", CalibrateRequest(**FEW, seed=3), lambda _what, share: told.append(share)
    )
    stored, records = load_stored(my_twin, "m")
    assert found.next == "avahazard compare m"
    assert stored.calibration == replace(found, next=None)
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


LEVELS = """
from avahazard.effects.effect import Parameter
KEY, MEANING, NEEDS = "snow", "Snow types rub differently.", ["snow_type"]
LEVELS = {levels}
PARAMETERS = [Parameter(k, "log friction", 0.0, 0.0, {sd!r}) for k in LEVELS]
def friction(columns):
    return [columns.texts["snow_type"] == k for k in LEVELS]
"""


@pytest.mark.slow
def test_the_right_effect_lowers_the_held_out_error_and_a_wrong_one_does_not(
    snow_database: str,
) -> None:
    right = add(snow_database, "base", ["snow-type"], "snow")
    wrong = add(snow_database, "base", ["season"], "season")
    assert (right.model, right.parent, right.effects) == ("snow", "base", ("snow-type",))
    found = right.comparison
    assert found.after.held_out_crps_m < 0.85 * found.before.held_out_crps_m
    assert found.after.noise_floor_crps_m < found.after.held_out_crps_m
    other = wrong.comparison
    assert other.after.held_out_crps_m > 0.98 * other.before.held_out_crps_m
    assert other.before == found.before
    rows = ladder(snow_database).rows
    assert [(r.model, r.parent, r.added) for r in rows] == [
        ("base", None, ()),
        ("snow", "base", ("snow-type",)),
        ("season", "base", ("season",)),
    ]
    assert rows[1].held_out_crps_m == found.after.held_out_crps_m
    with reading(snow_database) as session:
        assert latest_result(session, COMPARISON, "base") is not None


@pytest.mark.slow
def test_a_child_whose_comparison_cannot_be_stored_is_not_stored_either(
    snow_database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def discontinuous(*_: object) -> None:
        raise OSError("killed")

    with monkeypatch.context() as patched:
        patched.setattr("avahazard.store.results.save_result", discontinuous)
        with pytest.raises(OSError, match="killed"):
            add(snow_database, "base", ["season"], "season")
    with reading(snow_database) as session:
        assert [model.name for model in list_models(session)] == ["base"]
    assert add(snow_database, "base", ["season"], "season").comparison is not None


def test_a_changed_effect_file_is_not_run(
    snow_database: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = LEVELS.format(levels=["wet", "dry"], sd=0.2)
    file = tmp_path / "own.py"
    file.write_text(text, encoding="utf-8")
    with writing(snow_database) as session:
        kept = load_model(session, "base").specification
        kept = {**kept, "specification": {**kept["specification"], "effects": ["snow"]}}
        save_bare(session, "own", kept, effect_file=text)
        stored = load_model(session, "own")
    file.write_text(text + "print('it ran')\n", encoding="utf-8")
    for use in (
        lambda: own_effects(stored, [file]),
        lambda: add(snow_database, "own", ["season"], "more", effect_files=[file]),
    ):
        with pytest.raises(AvahazardError, match="it was not run"):
            use()
    assert capsys.readouterr().out == ""
    file.write_text(text, encoding="utf-8")
    assert [d.key for d in own_effects(stored, [file])] == ["snow"]


@pytest.mark.slow
def test_a_child_of_a_child(snow_database: str) -> None:
    add(snow_database, "base", ["snow-type"], "snow")
    below = add(snow_database, "snow", ["path-effect"], "more")
    assert below.effects == ("snow-type", "path-effect")
    # Other paths say nothing of its offsets: the scores of both are by folds of events.
    assert below.comparison.held_out_by == "fold"
    assert "path:P01" in below.parameters
    assert ladder(snow_database).rows[2].added == ("path-effect",)
    before = below.comparison.before
    assert before is not None
    # Another comparison does not forget what the parent has by the same folds.
    assert compare(snow_database, "more").held_out.parent_crps_m == before.held_out_crps_m


@pytest.mark.slow
def test_an_effect_from_a_file_is_as_good_as_one_of_the_catalogue(
    snow_database: str, tmp_path: Path, snow_world: Path
) -> None:
    add(snow_database, "base", ["snow-type"], "built-in")
    built_in, _ = load_stored(snow_database, "built-in")
    file = tmp_path / "snow.py"
    facts = built_in.facts["snow-type"]
    text = LEVELS.format(levels=facts["levels"], sd=facts["prior_sd"])
    file.write_text(text, encoding="utf-8")
    child = add(snow_database, "base", ["snow"], "own", effect_files=[file])
    assert child.effects == ("snow",)
    with reading(snow_database) as session:
        model = load_model(session, "own")
    assert model.effect_file == file.read_text()
    draws: dict[str, list[float | None]] = {}
    for name, files in (("built-in", []), ("own", [file])):
        rows = predict(
            snow_database, name, snow_world / "world" / "events.csv", effect_files=files
        ).events
        draws[name] = [row.mean_m for row in rows]
        run = run_block(
            snow_database, "P01", RunoutRequest(model=name, volume_m3=2e4, effect_files=files)
        )
        draws[name].append(run.runout_x_m)
    # The same posterior to the last bit, and so the same predictions.
    assert draws["own"] == draws["built-in"]
    with pytest.raises(AvahazardError, match="from a file"):
        predict(snow_database, "own", snow_world / "world" / "events.csv")
    with pytest.raises(AvahazardError, match="from a file"):
        run_block(snow_database, "P01", RunoutRequest(model="own", volume_m3=2e4))
    with pytest.raises(AvahazardError, match="from a file"):
        add(snow_database, "own", ["season"], "child")
    child = add(snow_database, "own", ["season"], "child", effect_files=[file])
    assert child.effects == ("snow", "season")
    file.write_text(file.read_text() + "\n# changed\n", encoding="utf-8")
    with pytest.raises(AvahazardError, match="not the one"):
        add(snow_database, "own", ["path-section"], "other", effect_files=[file])


@pytest.mark.slow
def test_the_child_starts_where_its_parent_is(snow_database: str) -> None:
    """A neutral effect leaves the posterior where it was: the base parameters agree."""
    child = add(snow_database, "base", ["path-section"], "section")
    parent, _ = load_stored(snow_database, "base")
    a = parent.calibration.parameters["a"]
    assert child.parameters["a"].mean == pytest.approx(a.mean, abs=4 * a.sd)
    assert child.seed == parent.calibration.seed
    assert np.isfinite(child.comparison.after.elpd_loo)


def test_what_cannot_be_added(snow_database: str, tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text(TEMPLATE, encoding="utf-8")
    for arguments, files, message in (
        (("base", ["nonsense"], "new"), [], "There is no effect"),
        (("base", ["snow-type"], "base"), [], "There is a model base"),
        (("nobody", ["snow-type"], "new"), [], "There is no model"),
        (("base", ["centrifugal"], "new"), [], "has centrifugal already"),
        (("base", ["covariate:nothing"], "new"), [], "cannot be estimated"),
        (("base", ["season"], "new"), [file], "is not asked for"),
    ):
        with pytest.raises(AvahazardError, match=message):
            add(snow_database, *arguments, effect_files=files)
    with reading(snow_database) as session:
        assert [model.name for model in list_models(session)] == ["base"]
