"""`avahazard models`."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest
from typer.testing import Result

pytestmark = pytest.mark.usefixtures("drawn_little")

Run = Callable[..., Result]


def test_models_in_a_table_and_as_json(on_models: Run) -> None:
    done = on_models("models")
    assert done.exit_code == 0
    rows = [line.split() for line in done.stdout.splitlines() if "exponential" in line]
    assert [row[:4] for row in rows] == [
        ["base", "–", "exponential,", "marginal"],
        ["plain", "–", "exponential,", "gibbs"],
    ]
    assert max(map(len, done.stdout.splitlines())) <= 80
    base, plain = json.loads(on_models("--json", "models").stdout)
    assert (base["model"], base["parent"], base["converged"]) == ("base", None, True)
    assert (plain["method"], plain["effects"]) == ("gibbs", [])


def test_no_models_yet(on_twin: Run) -> None:
    done = on_twin("models")
    assert done.exit_code == 0
    assert "avahazard calibrate" in done.stdout
    assert json.loads(on_twin("--json", "models").stdout) == []
