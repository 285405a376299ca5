"""`avahazard volumes`, and the options of frequency of `hazard`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from tests.telling import untold


def run(database: Path, *words: str) -> Result:
    from avahazard.cli.main import app  # noqa: PLC0415

    return CliRunner().invoke(app, ["--db", str(database), *words], prog_name="avahazard")


def test_people_see_levels_and_where_they_come_from(model_database: Path) -> None:
    done = run(model_database, "volumes", "scey", "nants", "-T", "50", "-T", "5000")
    assert done.exit_code == 0
    words = " ".join(done.stdout.split())
    assert "scey 50 " in words
    assert "5000*" in words
    assert untold(words, "GEV", "extrapolation") == []
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_json_is_one_document(model_database: Path) -> None:
    done = run(model_database, "--json", "volumes", "scey", "--frequency", "gpd")
    (entry,) = json.loads(done.stdout)
    assert entry["levels"][0].keys() >= {"return_period_years", "volume_m3", "q05_m3", "q95_m3"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--threshold", "100"), "is for --frequency gpd"),
        (("--volumes", "a.csv", "--as-of", "2000"), "for volumes from records"),
        (("--frequency", "weibull"), "--frequency"),
    ],
)
@pytest.mark.parametrize("command", [("volumes",), ("hazard", "base")])
def test_wrong_usage(
    model_database: Path, command: tuple[str, ...], words: tuple[str, ...], message: str
) -> None:
    done = run(model_database, *command, *words)
    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr


def test_a_period_that_is_too_short_says_so(model_database: Path) -> None:
    done = run(model_database, "volumes", "-T", "1.001")
    assert done.exit_code == 0
    assert "no volume returns every 1.001 years" in " ".join(done.stderr.split())
