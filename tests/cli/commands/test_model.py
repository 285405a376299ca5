"""`avahazard model`."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable

from typer.testing import Result

from tests.cli.commands.conftest import PROGRAM
from tests.telling import untold

Run = Callable[..., Result]


def test_the_installed_command(model_database: str) -> None:
    done = subprocess.run(
        [PROGRAM, "--db", model_database, "--json", "model", "base"],
        check=True,
        capture_output=True,
        text=True,
    )
    document = json.loads(done.stdout)
    assert (document["model"], document["n_events"]) == ("base", 173)
    a = document["parameters"]["a"]
    assert a["q05"] < 0.519 < a["q95"]
    assert document["created"].endswith("Z")


def test_people_see_the_posterior_and_the_notes(on_models: Run) -> None:
    done = on_models("model", "plain")
    assert done.exit_code == 0
    assert untold(done.stdout, "plain", "exponential", "gibbs", "Converged", "R-hat", "UTC") == []
    assert untold(done.stderr, "gibbs", 173) == []


def test_a_model_that_is_not_there(on_models: Run) -> None:
    done = on_models("model", "nothing")
    assert (done.exit_code, done.stdout) == (1, "")
    assert untold(done.stderr, "nothing", "base", "plain") == []
