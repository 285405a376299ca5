"""`avahazard model`."""

from __future__ import annotations

import json
from collections.abc import Callable

from typer.testing import Result

from tests.telling import untold

Run = Callable[..., Result]


def test_the_document(on_models: Run) -> None:
    document = json.loads(on_models("--json", "model", "base").stdout)
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
