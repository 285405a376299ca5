"""Scores and failures as people read them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from avahazard.message import counted
from avahazard.results.amounts import RATIO, amount, bare, unit_of
from avahazard.results.comparison import Comparison, HeldOutScores, Scores
from avahazard.results.ladder import BeforeAndAfter
from avahazard.results.prediction import PredictionScores

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
