from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from avahazard.results.diagnosis import Diagnosis
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.import_files import import_files
from tests.criticism.lengths import as_csv, lengths
from tests.telling import untold

Command = Callable[..., Result]


@pytest.fixture
def base(database: str, write: Callable[[str, str], Path]) -> str:
    """Give a database with the model `base`, which does not know that column_1 matters."""
    import_files(database, [write("events.csv", as_csv(lengths(90, 0.12)))])
    calibrate(database, "base", law="power", chains=2, draws=100)
    return database


@pytest.mark.usefixtures("base")
def test_people_and_programs_read_what_is_missing_and_what_to_do(
    avahazard: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("diagnose", "base", "--worlds", "39")
    document = json.loads(avahazard("--json", *words).stdout)
    assert document["verdict"] == "unexplained"
    assert document["missing"] == ["covariate:column_1"]
    # The same diagnosis, in words.
    found = Diagnosis.from_dict(document)
    monkeypatch.setattr("avahazard.workflow.diagnose.diagnose_model", lambda *_, **__: found)
    result = avahazard(*words)
    assert result.exit_code == 0
    verdict = result.stdout.split("\n\n")[0]
    assert untold(verdict, "base", "covariate:column_1", "avahazard effect new FILE") == []
    assert untold(result.stdout, "nats") == []


def test_an_unknown_model_is_one_message_and_a_hint(avahazard: Command) -> None:
    result = avahazard("diagnose", "nobody")
    assert result.exit_code == 1
    assert "nobody" in result.stderr
    assert "Traceback" not in result.stderr


def test_too_few_worlds_are_wrong_usage(avahazard: Command) -> None:
    result = avahazard("diagnose", "base", "--worlds", "10")
    assert result.exit_code == 2
    assert "39" in result.stderr
