"""Calibrated models, their scores and where they fail, for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from rich.console import Console

from avahazard.cli.output import number, table
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.specification import GIVEN
from avahazard.notes import counted
from avahazard.results.base import RATIO, amount, bare, unit_of
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison, HeldOutScores, Scores
from avahazard.results.ladder import BeforeAndAfter
from avahazard.results.prediction import PredictionScores

COLUMNS_OF = ("mean", "sd", "q05", "q95", "mode")
POSTERIOR_COLUMNS = ("", ">mean", ">± sd", ">5 %", ">95 %", ">mode", "unit")
LONGEST_NAME = 26
"""Names of parameters up to here stand on one line."""
LONGEST_UNIT = 14
"""Units up to here do so beside the longest of these names, in 80 columns."""


def show_calibration(console: Console, model: Calibration) -> None:
    """Print what a calibration found."""
    parameters = model.parameters
    rows = [
        (name, *(_as_sure_as(p.sd, getattr(p, key)) for key in COLUMNS_OF), _unit(p.unit))
        for name, p in parameters.items()
    ]
    made = table(_title(model), POSTERIOR_COLUMNS, rows)
    # Units are folded before names are, but no word of theirs; and numbers never: half of 3.4e-06
    # is another number.
    for column in made.columns[1:-1]:
        column.no_wrap = True
    name = max(map(len, parameters), default=0)
    numbers = sum(
        max(map(len, values), default=0) for values in list(zip(*rows, strict=True))[1:-1]
    )
    word = max((len(word) for row in rows for word in row[-1].split()), default=0)
    fits = name + numbers + word + 2 * len(POSTERIOR_COLUMNS) <= console.width
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
    if METHODS[model.method].knows_errors:
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


MOST_LINES = 6
SIGNIFICANT = 0.05


COORDINATES = {
    "elevation": "elevation z, m",
    "x": "distance x, m",
    "length": "runout length, m",
    RATIO: "H/L",
    "mixed": "as recorded, m",
}
"""What the scores of a coordinate are of."""
SOURCES = {
    "record": "errors of the recorded runouts",
    "volume": "errors of the recorded volumes",
    "release": "errors of the recorded releases",
    "scatter": "natural scatter",
    "parameters": "uncertain parameters",
    "unexplained": "unexplained",
}
"""Sources of error in words."""
CRPS_WORDS = (
    "CRPS: mean error in metres that counts the width of the forecast too; for a forecast without "
    "scatter it is the mean absolute error. Smaller is better."
)


def show_scores(
    coordinate: str,
    *parts: tuple[str, Scores | HeldOutScores | PredictionScores],
) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Columns and rows of a table of scores: runouts in each coordinate, and speeds if any.

    `coordinate` is that of the records.
    """
    rows: list[tuple[Any, ...]] = []
    for name, scores in parts:
        found: list[tuple[str, str, Any]] = [(COORDINATES[coordinate], "m", scores.runout)]
        if coordinate != "x" and scores.runout_x is not None:
            found.append((COORDINATES["x"], "m", scores.runout_x))
        if scores.speed is not None:
            found.append(("speed, m/s", "m_s", scores.speed))
        rows += [
            (
                name,
                what,
                one.n,
                *(
                    bare(getattr(one, f"{key}_{unit}"), coordinate if unit == "m" else None)
                    for key in ("rmse", "bias", "crps")
                ),
                f"{one.coverage_50:.0%}",
                f"{one.coverage_90:.0%}",
            )
            for what, unit, one in found
        ]
    return ("", "of", ">n", ">RMSE", ">bias", ">CRPS", ">in 50 %", ">in 90 %"), rows


def failures(comparison: Comparison) -> Iterator[str]:
    """The worst axes in words, significant ones only, or that there is none."""
    worst = [row for row in comparison.where_it_fails if row.p_value < SIGNIFICANT]
    fast = [
        row
        for row in comparison.speed_misfit or ()
        if row.p_value is not None and row.p_value < SIGNIFICANT
    ]
    for speeds in fast:
        size = f"{abs(speeds.bias_m_s):.1f} m/s {'slower' if speeds.bias_m_s > 0 else 'faster'}"
        yield (
            f"speeds, {speeds.axis} {speeds.level} ({speeds.n}): measured {size} than predicted, "
            f"{_chance(speeds.p_value or 0.0)}."
        )
    if not worst and not fast:
        yield "nowhere that chance could not explain (corrected p > 0.05 on every axis)."
    for row in worst[:MOST_LINES]:
        yield (
            f"{row.axis}, {row.level} ({counted(row.n, 'event')}): recorded "
            f"{_direction(comparison.coordinate, row.bias_m)}, {_chance(row.p_value)}."
        )
    if len(worst) > MOST_LINES:
        yield f"and on {len(worst) - MOST_LINES} levels more (--json has them all)."


def unit_words(coordinate: str) -> str:
    """Metres of what, in a sentence."""
    of = {
        "elevation": "m of elevation",
        "x": "m of x",
        "length": "m of runout length",
        RATIO: "H/L",
    }
    return of.get(coordinate, "m, as recorded")


def crps_words(coordinate: str | None) -> str:
    """What the CRPS is, in the unit of the records."""
    return CRPS_WORDS.replace("metres", unit_of(coordinate)) if coordinate == RATIO else CRPS_WORDS


def budget_table(found: Comparison) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Columns and rows of the error budget: metres, and the share of the squared error."""
    whole = sum(part.rms_m**2 for part in found.budget)
    rows = [
        (
            SOURCES.get(part.source, f"explained by {part.source}"),
            bare(part.rms_m, found.coordinate),
            f"{part.rms_m**2 / whole:.0%}" if whole > 0.0 else "-",
        )
        for part in found.budget
    ]
    unit = unit_of(found.coordinate)
    return ("where the error comes from", f">rms, {unit}", ">share of squares"), rows


def profile_words(profile_m: float, coordinate: str) -> str:
    """How much of the error may be that of the profiles' points."""
    return (
        f"Errors of the profiles' points move the predicted stops by "
        f"{amount(profile_m, coordinate)} (rms): a part of the scatter and of what is unexplained, "
        "not one beside them."
    )


def error_words(found: Comparison | BeforeAndAfter) -> str:
    """What the errors of the records alone account for."""
    floor = found.scores.runout if isinstance(found, Comparison) else found
    return (
        f"Errors of the records alone (runout, volume, release) would leave a CRPS of "
        f"{amount(floor.noise_floor_crps_m, found.coordinate)} (RMSE "
        f"{amount(floor.noise_floor_m, found.coordinate, 0)}). What varies from avalanche to "
        "avalanche comes on top for every model."
    )


def fall_of_error(found: BeforeAndAfter) -> str:
    """How far the error fell: that of `compare`, on what was held out."""
    by = "paths" if found.held_out_by == "path" else "folds"
    what = f"Error (CRPS in {unit_words(found.coordinate)}, {by} held out)"
    after = found.after.held_out_crps_m
    if found.before is None:
        return f"{what}: {amount(after, found.coordinate)}. {error_words(found)}"
    before = found.before.held_out_crps_m
    text = f"{what} {_change(before, after, found.coordinate)}"
    if found.fall is not None:
        low = bare(found.fall.q05_m, found.coordinate)
        high = amount(found.fall.q95_m, found.coordinate)
        text += f" (by {low} to {high} with 90 % confidence)"
    x = (found.before.held_out_crps_x_m, found.after.held_out_crps_x_m)
    if found.coordinate != "x" and x[0] is not None and x[1] is not None:
        text += f"; in x it {_change(x[0], x[1], 'x')}"
    return f"{text}. {error_words(found)}"


def _direction(coordinate: str, bias: float) -> str:
    """Where the records lie against the prediction."""
    size = amount(abs(bias), coordinate, 0)
    if coordinate == RATIO:
        return f"{size} {'lower (farther)' if bias > 0 else 'higher (shorter)'} than predicted"
    if coordinate == "elevation":
        return f"{size} of elevation {'lower' if bias > 0 else 'higher'} than predicted"
    if coordinate == "mixed":
        return f"{size} {'farther down' if bias > 0 else 'less far down'} than predicted"
    along = "x" if coordinate == "x" else "runout length"
    return f"{size} of {along} {'shorter' if bias > 0 else 'farther'} than predicted"


def _chance(p: float) -> str:
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"


def _change(before: float, after: float, coordinate: str) -> str:
    verb = "fell" if after < before else "rose"
    numbers = f"{bare(before, coordinate)} to {amount(after, coordinate)}"
    return f"{verb} from {numbers} ({(after - before) / before:+.1%})"
