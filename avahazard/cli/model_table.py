"""A calibrated model for people: its parameters, and whether its chains converged."""

from __future__ import annotations

import math

from rich.console import Console

from avahazard.cli.output import number, table
from avahazard.inference.model.given_prior import GIVEN
from avahazard.message import counted
from avahazard.results.calibration import Calibration

SHOWN = ("mean", "sd", "q05", "q95", "mode")
COLUMNS = ("", ">mean", ">± sd", ">5 %", ">95 %", ">mode", "unit")
LONGEST_NAME = 26
"""Names of parameters up to here stand on one line."""
LONGEST_UNIT = 14
"""Units up to here do so beside the longest of these names, in 80 columns."""


def show_calibration(console: Console, model: Calibration) -> None:
    """Print what a calibration found."""
    parameters = model.parameters
    rows = [
        (name, *(_as_sure_as(p.sd, getattr(p, key)) for key in SHOWN), _unit(p.unit))
        for name, p in parameters.items()
    ]
    made = table(_title(model), COLUMNS, rows)
    # Units are folded before names are, but no word of theirs; and numbers never: half of 3.4e-06
    # is another number.
    for column in made.columns[1:-1]:
        column.no_wrap = True
    name = max(map(len, parameters), default=0)
    numbers = sum(
        max(map(len, values), default=0) for values in list(zip(*rows, strict=True))[1:-1]
    )
    word = max((len(word) for row in rows for word in row[-1].split()), default=0)
    fits = name + numbers + word + 2 * len(COLUMNS) <= console.width
    made.columns[0].no_wrap = name <= LONGEST_NAME and fits
    console.print(made)
    given = model.given_priors or {}
    if given:
        told = (f"{key} {p.mean:g} ± {p.sd:g} {p.unit}".rstrip() for key, p in given.items())
        console.print(f"Priors as given: {', '.join(told)}.")
    checks = model.diagnostics
    console.print(
        f"{counted(model.n_events, 'event')}; {model.chains} chains of {model.draws} "
        f"draws, seed {model.seed}; {checks.acceptance:.0%} accepted."
    )
    console.print(
        f"{'Converged' if checks.converged else 'Not converged'}: R-hat "
        f"{_digits(checks.rhat_max)}, effective sample size at least "
        f"{number(round(checks.ess_min))}."
    )


def _unit(unit: str) -> str:
    """The unit in the words that fold over the fewest lines."""
    return (unit if len(unit) <= LONGEST_UNIT else unit.replace("log friction", "log μ")) or "–"


def _title(model: Calibration) -> str:
    parts = [model.law + " law", model.method]
    if model.method == "marginal":
        parts.append(model.distribution)
    if model.scatter == "volume":
        parts.append("scatter by volume")
    if model.tails == "student":
        parts.append("Student's tails")
    if not model.centrifugal:
        parts.append("without centrifugal")
    if model.effects:
        parts.append("with " + ", ".join(model.effects))
    if model.prior is not None and not model.prior.source.startswith(GIVEN):
        parts.append(f"prior from {model.prior.source}")
    return f"{model.model}: {', '.join(parts)}"


def _as_sure_as(sd: float, value: float) -> str:
    """The value with as many decimals as two digits of its standard deviation have."""
    decimals = 1 - math.floor(math.log10(sd)) if sd > 0.0 else 0
    return f"{value:.{max(decimals, 0)}f}" if decimals < 6 and abs(value) < 1e7 else f"{value:.3g}"


def _digits(rhat: float | None) -> str:
    return "infinite" if rhat is None else f"{rhat:.3f}"
