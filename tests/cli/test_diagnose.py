from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from avahazard.results.base import Rows
from avahazard.results.diagnosis import Diagnosis, MeasuredAmount
from avahazard.workflow.requests import DiagnoseRequest
from tests.results.samples import CANDIDATE, DIAGNOSIS
from tests.telling import untold

Command = Callable[..., Result]


def test_people_and_programs_read_what_is_missing_and_what_to_do(
    avahazard: Command, diagnosed_world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = json.loads((diagnosed_world / "diagnosis.json").read_text(encoding="utf-8"))
    found = Diagnosis.from_dict(given)
    asked: list[dict[str, Any]] = []

    def diagnose(name: str, request: DiagnoseRequest) -> Diagnosis:
        asked.append({"name": name, "seed": request.seed})
        return found

    monkeypatch.setattr("avahazard.workflow.diagnose.diagnose_model", diagnose)
    words = ("diagnose", "base", "--seed", "3")
    assert json.loads(avahazard("--json", *words).stdout) == given
    result = avahazard(*words)
    assert result.exit_code == 0
    verdict = result.stdout.split("\n\n")[0]
    assert untold(verdict, "base", "covariate:column_1") == []
    assert untold(result.stdout, "nats", given["next"].removeprefix("avahazard ")) == []
    assert asked == [{"name": "base", "seed": 3}] * 2


def test_an_unknown_model_is_one_message_and_a_hint(avahazard: Command) -> None:
    result = avahazard("diagnose", "nobody")
    assert result.exit_code == 1
    assert "nobody" in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(("value", "far"), [(0.0031, False), (0.0019, True)])
def test_a_force_that_is_measured_otherwise_than_fitted_is_said(
    avahazard: Command, monkeypatch: pytest.MonkeyPatch, value: float, far: bool
) -> None:
    drag = replace(
        CANDIDATE,
        effect="turbulent-drag",
        parameters={"turbulent-drag.drag": 0.003},
        force_witness=MeasuredAmount(value, 2e-4),
        shape=None,
    )
    found = replace(DIAGNOSIS, candidates=Rows([drag]))
    monkeypatch.setattr("avahazard.workflow.diagnose.diagnose_model", lambda **_: found)
    result = avahazard("diagnose", "base")
    assert f"is {value} ± 0.0002 (fitted: 0.003" in " ".join(result.stdout.split())
    assert ("another form of it may act" in " ".join(result.stdout.split())) is far
