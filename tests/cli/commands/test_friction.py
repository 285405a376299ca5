"""`avahazard friction`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

from tests.telling import untold

Run = Callable[..., Result]


def test_the_document(document: Callable[..., Any]) -> None:
    found = document("friction")
    assert len(found["events"]) == 173
    assert found["events"][0].keys() >= {"event_id", "path_id", "mu", "mu_sd", "status"}
    densities = {density["path_id"]: density for density in found["density"]}
    assert len(densities) == 8
    whole = densities["all"]
    assert whole["kappa"] == 5.0
    # All but the tails beyond 2.5/κ on each side, e^-5 of what lies beyond the records.
    assert 0.98 < np.trapezoid(whole["pdf"], whole["mu"]) < 1.0
    assert found["perturbation"]["parameters"]["a"]["sd"] > 0.0


def test_people_see_paths_or_the_events_of_one(on_twin: Run, tmp_path: Path) -> None:
    paths = on_twin("friction")
    assert paths.exit_code == 0
    assert "grand-chantey" in paths.stdout
    assert "2 below" in paths.stdout
    file = tmp_path / "density.svg"
    events = on_twin("friction", "scey", "--kappa", "auto", "--plot", str(file))
    assert sum(line.strip().startswith("scey-0") for line in events.stdout.splitlines()) == 15
    assert "<svg" in file.read_text(encoding="utf-8")
    for done in (paths, events):
        assert max(map(len, done.stdout.splitlines())) <= 80


def test_kappa_is_chosen_or_given(on_twin: Run) -> None:
    kappas = []
    for kappa in ("7", "auto"):
        done = on_twin("--json", "friction", "scey", "--kappa", kappa)
        kappas.append(json.loads(done.stdout)["density"][0]["kappa"])
    assert kappas[0] == 7.0
    assert kappas[1] not in (5.0, 7.0)


@pytest.mark.parametrize("kappa", ["0", "-1", "nan", "inf", "soft"])
def test_a_kappa_that_is_none(on_twin: Run, kappa: str) -> None:
    done = on_twin("friction", "--kappa", kappa)
    assert (done.exit_code, done.stdout) == (2, "")
    assert "--kappa" in done.stderr


def test_nothing_to_show(avahazard: Run, on_twin: Run) -> None:
    empty = avahazard("friction")
    assert (empty.exit_code, empty.stdout) == (1, "")
    assert "no events" in empty.stderr
    unknown = on_twin("friction", "everest")
    assert unknown.exit_code == 1
    assert untold(unknown.stderr, "'everest'") == []


def test_under_a_model(on_models: Run, tmp_path: Path) -> None:
    document = json.loads(on_models("--json", "friction", "scey", "--model", "base").stdout)
    assert document["model"] == "base"
    assert all("mu_reference" in event for event in document["events"] if event["mu"])
    file = tmp_path / "law.svg"
    done = on_models("friction", "--model", "base", "--plot", str(file))
    assert untold(done.stdout, "with the effects of base") == []
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "<svg" in file.read_text(encoding="utf-8")
    unknown = on_models("friction", "--model", "nothing")
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    assert untold(unknown.stderr, "model nothing") == []
