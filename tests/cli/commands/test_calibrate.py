"""`avahazard calibrate`."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from tests.conftest import command_line
from tests.telling import untold

Run = Callable[..., Result]
SHORT = ("--draws", "100", "--chains", "2", "--path", "scey", "--path", "saugy")
KEYS = {
    *("model", "parent", "law", "scatter", "distribution", "method", "effects", "n_events"),
    *("parameters", "diagnostics", "seed", "data_fingerprint"),
}


@pytest.fixture
def selected(twin_database: str, tmp_path: Path) -> Run:
    """Give a function that runs the command line on a copy of the twin."""
    return command_line(shutil.copy(twin_database, tmp_path / "mine.db"))


def test_the_document(selected: Run) -> None:
    document = json.loads(selected("--json", "calibrate", "m", *SHORT, "--seed", "4").stdout)
    assert document.keys() >= KEYS
    assert document["parameters"].keys() == {"a", "n", "sigma"}
    assert document["parameters"]["n"].keys() == {"mean", "sd", "mode", "q05", "q95", "unit"}
    assert document["diagnostics"].keys() >= {
        *("rhat_max", "ess_bulk_min", "acceptance", "divergent_or_stuck_chains")
    }
    assert (document["model"], document["n_events"], document["seed"]) == ("m", 34, 4)


def test_people_see_the_posterior(selected: Run) -> None:
    done = selected("calibrate", "m", *SHORT, "--law", "power", "--tails", "student")
    assert done.exit_code == 0
    model = ("m", "power", "marginal", "lognormal", "Student's", "alpha")
    assert untold(done.stdout, *model, "34 events", "2 chains", "100 draws", "seed 0") == []
    lines = [x for x in done.stdout.splitlines() if not x.startswith("  avahazard")]
    assert max(map(len, lines)) <= 80


def test_a_prior_as_numbers_is_told(selected: Run) -> None:
    done = selected(
        "calibrate", "m", *SHORT, "--prior", "n=2e-6,1e-6", "--prior", "sigma = 0.2, 0.05"
    )
    assert done.exit_code == 0
    assert "the prior of sigma in m is 0.2 ± 0.05, as given." in done.stderr
    shown = json.loads(selected("--json", "model", "m").stdout)
    assert "the prior of n in m is 2e-06 ± 1e-06, as given." in shown["notes"]
    provenance = selected("model", "m", "--provenance").stdout
    assert untold(provenance, "n 2e-06 ± 1e-06, sigma 0.2 ± 0.05", "given:n") == []
    assert "{" not in provenance


def test_a_run_that_has_not_converged_says_so_and_ends_with_0(selected: Run) -> None:
    done = selected("calibrate", "m", "--draws", "50", "--chains", "2", "--path", "scey")
    assert done.exit_code == 0
    assert "Not converged" in done.stdout
    assert "have not converged" in done.stderr
    shown = json.loads(selected("--json", "model", "m").stdout)
    assert shown["diagnostics"]["converged"] is False


def test_equal_seeds_equal_output(selected: Run) -> None:
    first = selected("--json", "calibrate", "a", *SHORT, "--seed", "9").stdout
    second = selected("--json", "calibrate", "b", *SHORT, "--seed", "9").stdout
    assert first.replace('"a",', '"b",', 1).replace("compare a", "compare b") == second


@pytest.mark.parametrize("method", ["metropolis", "gibbs"])
def test_the_papers_methods_leave_out_what_left_the_profile(selected: Run, method: str) -> None:
    done = selected(
        "--json", "calibrate", "m", "--method", method, "--chains", "2", "--draws", "200"
    )
    document = json.loads(done.stdout)
    left = sum(document["left_out"].values())
    assert document["n_events"] + left == 173
    assert document["left_out"]["beyond the profile"] > 0
    assert untold(done.stderr, method, left, 173) == []
    assert document["parameters"]["sigma"]["unit"] == ("m" if method == "metropolis" else "")


@pytest.mark.parametrize(
    ("words", "message", "hint"),
    [
        (["--path", "nowhere"], "'nowhere'", "scey"),
        (["--with", "ghosts"], "'ghosts'", "turbulent-drag"),
        (["--without", "season"], "'season'", "centrifugal"),
        (["--with", "forest-drag"], "'forest-drag'", "land_cover"),
        (["--method", "gibbs", "--law", "rational"], "rational law", "--method marginal"),
        (["--method", "metropolis", "--scatter", "volume"], "scatter", "--method marginal"),
        (["--prior", "a:0.5"], "'a:0.5' is no prior", "--prior a=0.5,0.05"),
        (["--prior", "a=0,5"], "a is positive", "over 0"),
        (["--prior", "a=0.5,0.1", "--prior", "a=0.4,0.1"], "two priors of 'a'", "Give one"),
        (["--prior", "c=0.5,0.1"], "no prior of 'c'", "a, n, sigma"),
    ],
)
def test_what_cannot_be_calibrated(on_twin: Run, words: list[str], message: str, hint: str) -> None:
    done = on_twin("calibrate", "m", *words)
    assert (done.exit_code, done.stdout) == (1, "")
    assert message in done.stderr
    assert hint in done.stderr
    assert "Traceback" not in done.stderr


def test_a_name_that_is_taken(on_models: Run) -> None:
    done = on_models("calibrate", "base")
    assert (done.exit_code, done.stdout) == (1, "")
    assert untold(done.stderr, "model base", "already") == []


def test_an_empty_database(avahazard: Run) -> None:
    done = avahazard("calibrate", "m")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "avahazard import" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["m", "--law", "cubic"],
        ["m", "--draws", "3"],
        ["m", "--chains", "1"],
        ["m", "--seed=-1"],
    ],
)
def test_wrong_usage(on_twin: Run, words: list[str]) -> None:
    done = on_twin("calibrate", *words)
    assert (done.exit_code, done.stdout) == (2, "")
