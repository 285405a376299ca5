"""A calibrated model for people."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

from rich.console import Console

from avahazard.cli.model_tables import show_calibration
from avahazard.results.calibration import Calibration, Convergence, GivenTold, ParameterSummary
from tests.results.samples import CALIBRATION
from tests.telling import untold

MODEL = replace(
    CALIBRATION,
    distribution="normal",
    scatter="volume",
    tails="student",
    centrifugal=False,
    effects=("season", "path-effect"),
    parameters={
        "a": ParameterSummary(0.51872, 0.0073, 0.5, 0.5, 0.53, ""),
        "n": ParameterSummary(3.36e-7, 1e-8, 3.3e-7, 3.2e-7, 3.5e-7, "1/m3"),
        "b": ParameterSummary(1.0, 0.0, 1.0, 1.0, 1.0, ""),
        "sigma": ParameterSummary(124.36, 6.8, 122.0, 113.0, 135.0, "m"),
    },
)


def _text(model: Calibration) -> str:
    out = StringIO()
    show_calibration(Console(file=out, width=80), model)
    return out.getvalue()


def test_values_have_the_digits_that_are_known() -> None:
    rows = {line.split()[0]: line.split()[1:] for line in _text(MODEL).splitlines() if line.split()}
    assert rows["a"] == ["0.5187", "0.0073", "0.5000", "0.5300", "0.5000", "–"]
    assert rows["n"] == ["3.36e-07", "1e-08", "3.2e-07", "3.5e-07", "3.3e-07", "1/m3"]
    assert rows["b"][:2] == ["1", "0"]
    assert rows["sigma"][:2] == ["124.4", "6.8"]


def test_what_the_model_is_and_how_it_went() -> None:
    model = ("m", "exponential", "marginal", "normal", "scatter by volume", "Student's")
    effects = ("without centrifugal", "season", "path-effect")
    run = ("12 events", "4 chains", "100 draws", "seed 7", "31%", "Converged", 1.002, 800)
    assert untold(_text(MODEL), *model, *effects, *run) == []


def test_stuck_chains() -> None:
    checks = Convergence(None, 0.0, 0.0, 0.0, 4, False)
    text = _text(replace(MODEL, diagnostics=checks))
    assert untold(text, "Not converged", "infinite") == []


def test_names_stay_on_a_line_and_units_are_folded() -> None:
    summary = ParameterSummary(0.149, 0.057, 0.151, 0.053, 0.244, "log friction against dry")
    text = _text(replace(MODEL, parameters={"snow-type.mixed": summary}))
    assert any(line.split()[:1] == ["snow-type.mixed"] for line in text.splitlines())
    assert max(map(len, text.splitlines())) <= 80
    assert untold(text, "log μ against dry") == []


def test_the_units_of_season_fold_once() -> None:
    summary = ParameterSummary(0.149, 0.057, 0.151, 0.053, 0.244, "log friction per (60 days)2")
    offset = replace(summary, unit="log friction")
    named = {"season.bend": summary, "path:le-tour-de-l-eglise-b": offset}
    lines = [line.strip() for line in _text(replace(MODEL, parameters=named)).splitlines()]
    at = next(k for k, line in enumerate(lines) if line.startswith("season.bend"))
    assert lines[at].endswith("log μ per (60")
    assert lines[at + 1] == "days)2"
    assert lines[at + 2].startswith("path:le-tour-de-l-eglise-b")
    assert max(map(len, lines)) <= 80


def test_numbers_are_never_folded() -> None:
    """Half of 3.95e-06 at the end of a line reads as another number."""
    n = ParameterSummary(3.95e-6, 6.34e-7, 2.92e-6, 5.05e-6, 3.78e-6, "1/m3")
    slope = ParameterSummary(0.032, 0.07, -0.089, 0.143, 0.036, "log friction per spread")
    for name in ("covariate:temp_c.slope", "covariate:temperature_c.bend_1"):
        lines = _text(replace(MODEL, parameters={"n": n, name: slope})).splitlines()
        values = next(line.split() for line in lines if line.startswith(" n "))
        assert set(values[1:6]) == {"3.95e-06", "6.34e-07", "2.92e-06", "5.05e-06", "3.78e-06"}
        assert any(line.rstrip().endswith("spread") for line in lines)
        assert max(map(len, lines)) <= 80


def test_given_priors_are_told_with_their_units() -> None:
    told = {"n": GivenTold(2e-6, 1e-6, "1/m3"), "a": GivenTold(0.5, 0.05, "")}
    text = _text(replace(MODEL, given_priors=told))
    assert "Priors as given: n 2e-06 ± 1e-06 1/m3, a 0.5 ± 0.05." in text
