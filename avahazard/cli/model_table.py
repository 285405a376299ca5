"""A calibrated model for people: its parameters, and whether its chains converged."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console

from avahazard.cli.output import number, table

SHOWN = ("mean", "sd", "q05", "q95", "mode")
COLUMNS = ("", ">mean", ">± sd", ">5 %", ">95 %", ">mode", "unit")


def show_calibration(console: Console, document: dict[str, Any]) -> None:
    """Print the document of `calibrate`."""
    parameters = document["parameters"]
    rows = [
        (name, *(_as_sure_as(p["sd"], p[key]) for key in SHOWN), p["unit"] or "–")
        for name, p in parameters.items()
    ]
    console.print(table(_title(document), COLUMNS, rows))
    checks = document["diagnostics"]
    console.print(
        f"{document['n_events']} events; {document['chains']} chains of {document['draws']} "
        f"draws, seed {document['seed']}; {checks['acceptance']:.0%} accepted."
    )
    console.print(
        f"{'Converged' if checks['converged'] else 'Not converged'}: R-hat "
        f"{_digits(checks['rhat_max'])}, effective sample size at least "
        f"{number(round(checks['ess_bulk_min']))}."
    )


def _title(document: dict[str, Any]) -> str:
    parts = [document["law"] + " law", document["method"]]
    if document["method"] == "marginal":
        parts.append(document["distribution"])
    if document["scatter"] == "volume":
        parts.append("scatter by volume")
    if document["tails"] == "student":
        parts.append("Student's tails")
    if not document["centrifugal"]:
        parts.append("without centrifugal")
    if document["effects"]:
        parts.append("with " + ", ".join(document["effects"]))
    return f"{document['model']}: {', '.join(parts)}"


def _as_sure_as(sd: float, value: float) -> str:
    """The value with as many decimals as two digits of its standard deviation have."""
    decimals = 1 - math.floor(math.log10(sd)) if sd > 0.0 else 0
    return f"{value:.{max(decimals, 0)}f}" if decimals < 6 and abs(value) < 1e7 else f"{value:.3g}"


def _digits(rhat: float | None) -> str:
    return "infinite" if rhat is None else f"{rhat:.3f}"
