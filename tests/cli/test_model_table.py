"""A calibrated model for people."""

from __future__ import annotations

from io import StringIO

from rich.console import Console

from avahazard.cli.model_table import show_calibration

N = {"mean": 3.36e-7, "sd": 1e-8, "mode": 3.3e-7, "q05": 3.2e-7, "q95": 3.5e-7, "unit": "1/m3"}
DOCUMENT = {
    "model": "m",
    "law": "exponential",
    "method": "marginal",
    "distribution": "normal",
    "scatter": "volume",
    "tails": "student",
    "centrifugal": False,
    "effects": ["season", "path-effect"],
    "n_events": 12,
    "chains": 4,
    "draws": 100,
    "seed": 7,
    "parameters": {
        "a": {"mean": 0.51872, "sd": 0.0073, "mode": 0.5, "q05": 0.5, "q95": 0.53, "unit": ""},
        "n": N,
        "b": {"mean": 1.0, "sd": 0.0, "mode": 1.0, "q05": 1.0, "q95": 1.0, "unit": ""},
        "sigma": {
            "mean": 124.36,
            "sd": 6.8,
            "mode": 122.0,
            "q05": 113.0,
            "q95": 135.0,
            "unit": "m",
        },
    },
    "diagnostics": {
        "rhat_max": 1.0021,
        "ess_bulk_min": 812.4,
        "acceptance": 0.31,
        "converged": True,
    },
}


def _text(document: dict) -> str:
    out = StringIO()
    show_calibration(Console(file=out, width=80), document)
    return out.getvalue()


def test_values_have_the_digits_that_are_known() -> None:
    rows = {
        line.split()[0]: line.split()[1:] for line in _text(DOCUMENT).splitlines() if line.split()
    }
    assert rows["a"] == ["0.5187", "0.0073", "0.5000", "0.5300", "0.5000", "–"]
    assert rows["n"] == ["3.36e-07", "1e-08", "3.2e-07", "3.5e-07", "3.3e-07", "1/m3"]
    assert rows["b"][:2] == ["1", "0"]
    assert rows["sigma"][:2] == ["124.4", "6.8"]


def test_what_the_model_is_and_how_it_went() -> None:
    text = " ".join(_text(DOCUMENT).split())
    assert (
        "m: exponential law, marginal, normal, scatter by volume, Student's tails, "
        "without centrifugal, with season, path-effect" in text
    )
    assert "12 events; 4 chains of 100 draws, seed 7; 31% accepted." in text
    assert "Converged: R-hat 1.002, effective sample size at least 812." in text


def test_stuck_chains() -> None:
    checks = {"rhat_max": None, "ess_bulk_min": 0.0, "acceptance": 0.0, "converged": False}
    text = _text({**DOCUMENT, "diagnostics": checks})
    assert "Not converged: R-hat infinite" in text
