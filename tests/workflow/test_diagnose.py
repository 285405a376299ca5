from __future__ import annotations

import json
import shlex
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from avahazard.cli.main import app
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.comparison import SpeedMisfit
from avahazard.results.diagnosis import Diagnosis
from avahazard.store.results import DIAGNOSIS, latest_result
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files
from avahazard.workflow.diagnose import (
    check_expected,
    diagnose_model,
    failing_paths,
    unexplained_failures,
)
from avahazard.workflow.next_step import next_step
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from avahazard.workflow.stored import load_stored
from tests.criticism.lengths import as_csv, lengths
from tests.results.samples import COMPARISON, FAILURE

KEYS = {"model", "verdict", "missing", "candidates", "detectable_m", "measure_next"}
CANDIDATE_KEYS = {
    "effect", "gain", "p_value", "error_before_m", "error_after_m", "parameters", "physics",
    "confounded_with",
}  # fmt: skip
Write = Callable[[str, str], Path]


@pytest.fixture
def base(diagnosed_world: Path, tmp_path: Path) -> str:
    """Give a database with the model `base`, which does not know that column_1 matters."""
    return str(shutil.copy(diagnosed_world / "base.db", tmp_path / "mine.db"))


def diagnosed(database: str, **options: Any) -> Diagnosis:
    return diagnose_model(database, "base", DiagnoseRequest(**options))


def test_the_document_names_the_axis(diagnosed_world: Path) -> None:
    given = json.loads((diagnosed_world / "diagnosis.json").read_text(encoding="utf-8"))
    document = Diagnosis.from_dict(given)
    assert (diagnosed_world / "candidates.png").stat().st_size > 5000
    assert set(given) >= KEYS
    assert document.model == "base"
    assert document.verdict == "unexplained"
    assert document.missing == ("covariate:column_1",)
    for candidate in document.candidates:
        assert set(candidate.to_dict()) >= CANDIDATE_KEYS
        assert 0.0 < candidate.p_value <= 1.0
        assert candidate.physics
    best = document.candidates[0]
    assert best.error_after_m < best.error_before_m
    assert best.parameters["covariate:column_1.slope"] == pytest.approx(0.12, abs=0.08)
    assert [c.effect for c in document.candidates].count("covariate:column_1") == 1
    for step in document.measure_next:
        assert step.expected_gain > 0.0
    with reading(str(diagnosed_world / "diagnosed.db")) as session:
        stored = Diagnosis.from_dict(latest_result(session, DIAGNOSIS, "base"))
    assert given == document.to_dict()
    # The next step is decided anew each time.
    command = "avahazard add base covariate:column_1 --as base+covariate:column_1"
    assert given.pop("next") == command
    assert stored.to_dict() == given
    told = json.loads((diagnosed_world / "told.json").read_text(encoding="utf-8"))
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.slow
def test_the_same_seed_gives_the_same_document(base: str) -> None:
    assert diagnosed(base, seed=4) == diagnosed(base, seed=4)


def test_a_pair_is_expected_either_way(base: str) -> None:
    stored, _ = load_stored(base, "base")
    for pair in ("column_1*rock", "rock*column_1"):
        found = check_expected(stored, [f"interaction:{pair}", "covariate:rock"], ())
        assert found == ("interaction:column_1*rock", "covariate:rock")


def test_an_unknown_model_is_one_message(base: str) -> None:
    with pytest.raises(AvahazardError, match="nobody"):
        diagnose_model(base, "nobody", DiagnoseRequest())


def test_a_model_without_a_likelihood_for_effects_is_refused(database: str, write: Write) -> None:
    import_files(database, [write("events.csv", as_csv(lengths(30)))])
    calibrate(database, "base", CalibrateRequest(method="gibbs", chains=2, draws=100))
    with pytest.raises(AvahazardError, match="gibbs") as raised:
        diagnosed(database)
    assert "--method marginal" in (raised.value.hint or "")


def test_changed_records_are_refused(base: str, write: Write) -> None:
    more = as_csv(lengths(91, 0.12)).splitlines()
    import_files(base, [write("more.csv", "\n".join([more[0], more[-1]]) + "\n")])
    with pytest.raises(AvahazardError, match="have changed"):
        diagnosed(base)


def test_a_picture_that_cannot_be_is_refused_before_the_work(base: str, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError):
        diagnosed(base, plot=tmp_path / "candidates.xyz")


@pytest.mark.usefixtures("drawn_little")
def test_the_law_that_is_written_is_added_as_the_next_steps_say(base: str, tmp_path: Path) -> None:
    file = tmp_path / "law.py"
    found = diagnosed(base, write_effect=file)
    best, law = found.candidates[0], found.leading_law
    assert best.shape is not None
    assert best.shape.of == "column_1"
    assert len(best.shape.x) == len(best.shape.q05) == len(best.shape.q95)
    assert best.laws is not None
    assert law == best.laws[0]
    assert {one.form for one in best.laws} >= {"linear"}
    assert found.effect_file == str(file)
    text = file.read_text(encoding="utf-8")
    assert f"KEY = {law.effect!r}" in text
    assert "covariate:column_1" in text
    compare(base, "base")
    step = shlex.split(str(next_step(base, "base")))
    assert step == ["avahazard", "add", "base", law.effect, "--as", f"base+{law.effect}",
        "--effect-file", str(file)]  # fmt: skip
    done = CliRunner().invoke(app, ["--db", base, *step[1:]])
    assert done.exit_code == 0, done.output
    assert "falls from" in done.output
    # The child's commands name its file again.
    then = next_step(base, f"base+{law.effect}")
    assert str(then) == f"avahazard diagnose base+{law.effect} --effect-file {file}"
    with pytest.raises(AvahazardError, match="is there already"):
        diagnosed(base, write_effect=file)


def test_a_law_is_written_by_the_last_diagnosis_where_that_was_asked_the_same(
    base: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed(base)
    file = tmp_path / "law.py"

    def again(*_args: Any, **_options: Any) -> None:
        raise AssertionError("diagnosed again")

    monkeypatch.setattr("avahazard.workflow.diagnose.diagnose", again)
    written = diagnosed(base, write_effect=file)
    assert file.read_text(encoding="utf-8") == found.law_text
    assert replace(written, effect_file=None, next=found.next) == found
    for other in ({"seed": 1}, {"expect": ("covariate:column_1",)}, {"field_days": {"speed": 9.0}}):
        with pytest.raises(AssertionError, match="again"):
            diagnosed(base, write_effect=tmp_path / "other.py", **other)


def test_where_nothing_is_found_no_law_is_written(
    database: str, write: Write, tmp_path: Path
) -> None:
    import_files(database, [write("events.csv", as_csv(lengths(40, 0.0, 3, n_columns=1)))])
    calibrate(database, "base", CalibrateRequest(law="power", chains=2, draws=100))
    file = tmp_path / "law.py"
    done = CliRunner().invoke(
        app, ["--db", database, "diagnose", "base", "--write-effect", str(file)]
    )
    assert done.exit_code == 1
    assert "no effect that base lacks" in done.stderr
    assert not file.exists()
    # The diagnosis stands all the same.
    with reading(database) as session:
        assert latest_result(session, DIAGNOSIS, "base") is not None


def test_paths_that_fail_beyond_chance_are_named() -> None:
    rows = [
        replace(FAILURE, axis="path", level="P01", bias_m=41.2, p_value=0.01),
        replace(FAILURE, axis="path", level="P06", bias_m=-30.0, p_value=0.02),
        replace(FAILURE, axis="path", level="P03", bias_m=9.0, p_value=0.4),
        FAILURE,
    ]
    (words,) = failing_paths(replace(COMPARISON, where_it_fails=Rows(rows)))
    assert words == (
        "It fails beyond chance on P01 (+41 m) and P06 (-30 m); predicted minus recorded."
    )
    assert failing_paths(COMPARISON) == []


def test_failures_that_no_candidate_explains_are_told() -> None:
    clear = replace(COMPARISON, where_it_fails=Rows([replace(FAILURE, p_value=0.2)]))
    assert unexplained_failures(replace(clear, speed_misfit=None)) == []
    places = replace(clear, where_it_fails=Rows([replace(FAILURE, p_value=0.01)]))
    assert len(unexplained_failures(places)) == 1
    fast = SpeedMisfit("predicted_speed_m_s", FAILURE.level, 33, 5.8, 9.7, 0.01)
    (note,) = unexplained_failures(replace(clear, speed_misfit=Rows([fast])))
    assert "no candidate has evidence enough" in note
