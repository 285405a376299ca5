"""Children of a model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.effects.own_file import TEMPLATE
from avahazard.records.errors import AvahazardError
from avahazard.store.results import COMPARISON, latest_result, list_models, load_model, save_model
from avahazard.store.session import reading, writing
from avahazard.workflow.add import add
from avahazard.workflow.compare import ladder
from avahazard.workflow.effects import own_effects
from avahazard.workflow.predict import predict
from avahazard.workflow.runout import run_model
from avahazard.workflow.stored import load_stored

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
    assert found.noise_floor_crps_m < found.after.held_out_crps_m
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
    def broken(*_: object) -> None:
        raise OSError("killed")

    with monkeypatch.context() as patched:
        patched.setattr("avahazard.workflow.add.save_result", broken)
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
        save_model(session, "own", kept, effect_file=text)
    file.write_text(text + "print('it ran')\n", encoding="utf-8")
    for use in (
        lambda: own_effects(snow_database, "own", [file]),
        lambda: add(snow_database, "own", ["season"], "more", effect_files=[file]),
    ):
        with pytest.raises(AvahazardError, match="it was not run"):
            use()
    assert capsys.readouterr().out == ""
    file.write_text(text, encoding="utf-8")
    assert [d.key for d in own_effects(snow_database, "own", [file])] == ["snow"]


@pytest.mark.slow
def test_a_child_of_a_child(snow_database: str) -> None:
    add(snow_database, "base", ["snow-type"], "snow")
    below = add(snow_database, "snow", ["path-effect"], "more")
    assert below.effects == ("snow-type", "path-effect")
    assert "path:P01" in below.parameters
    assert ladder(snow_database).rows[2].added == ("path-effect",)


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
        run = run_model(snow_database, "P01", name, volume_m3=2e4, effect_files=files)
        draws[name].append(run.runout_x_m)
    # The same posterior to the last bit, and so the same predictions.
    assert draws["own"] == draws["built-in"]
    with pytest.raises(AvahazardError, match="from a file"):
        predict(snow_database, "own", snow_world / "world" / "events.csv")
    with pytest.raises(AvahazardError, match="from a file"):
        run_model(snow_database, "P01", "own", volume_m3=2e4)
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
        (("base", ["covariate:nothing"], "new"), [], "cannot be told"),
        (("base", ["season"], "new"), [file], "is not asked for"),
    ):
        with pytest.raises(AvahazardError, match=message):
            add(snow_database, *arguments, effect_files=files)
    with reading(snow_database) as session:
        assert [model.name for model in list_models(session)] == ["base"]
