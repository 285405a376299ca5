"""Friction varies with a column of numbers: in a shape the data choose, by height or season."""

from __future__ import annotations

from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Curve, Definition, Facts, FrictionEffect, Parameter, Sites
from avahazard.effects.levels import level_effect, level_facts, level_lacking

PREFIX = "covariate:"
VOLUME = "volume_m3"
N_KNOTS, N_PLACES = 5, 41
MIN_EVENTS = 20
LINEAR_SD, CURVED_SD = 0.2, 0.1
"""Prior standard deviations of log friction over one spread of the column: the line is freer
than the departures from it, which keeps the shape smooth."""


def covariate(column: str) -> Definition:
    """The effect of one column: a natural cubic spline of numbers, or a level for each text."""
    return Definition(
        key=PREFIX + column,
        meaning=f"Friction varies with {column}, for a reason that is not yet physics: a smooth "
        "curve (or a level for each value of a text) is fitted. Its shape may tell the reason.",
        needs=f"column {column}",
        build=partial(_build, column),
        lacking=partial(_lacking, column),
        facts=partial(_facts, column),
        event_columns=True,
        uses_volume=column == VOLUME,
        beyond=1,
        curve=partial(_curve, column),
        names_cause=False,
        column=column,
    )


def _lacking(column: str, columns: EventColumns, _sites: Sites) -> str | None:
    values = number_column(columns, column)
    if values is None:
        return level_lacking(column, columns)
    known = values[np.isfinite(values)]
    if len(known) >= MIN_EVENTS and len(np.unique(known)) >= 3:
        return None
    return level_lacking(column, columns)


def number_column(columns: EventColumns, name: str) -> Floats | None:
    """A column of numbers by its name in the files; None if there is none."""
    known = {
        VOLUME: columns.log_volume,
        "release_elevation_m": columns.release_elevation,
        "year": columns.year,
        "day_of_winter": columns.day_of_winter,
        "deposit_length_m": columns.deposit_length,
    }
    return known[name] if name in known else columns.numbers.get(name, columns.made.get(name))


def _facts(column: str, columns: EventColumns, _sites: Sites) -> Facts:
    values = number_column(columns, column)
    if values is None or len(np.unique(values[np.isfinite(values)])) < 3:
        return level_facts(column, columns)
    known = values[np.isfinite(values)]
    knots = np.unique(np.quantile(known, np.linspace(0.05, 0.95, N_KNOTS)))
    centre, scale = float(np.mean(known)), float(np.std(known))
    return {"knots": [float(k) for k in knots], "centre": centre, "scale": scale}


def _build(column: str, facts: Facts) -> FrictionEffect:
    if "levels" in facts:
        return level_effect(PREFIX + column, column, facts)
    knots, centre, scale = np.array(facts["knots"]), facts["centre"], facts["scale"]

    def design(columns: EventColumns) -> Floats:
        values = number_column(columns, column)
        if values is None:
            return np.zeros((len(columns), max(1, len(knots) - 1)))
        # A missing value counts as the mean of the column.
        return spline_columns(np.where(np.isfinite(values), values, centre), knots, centre, scale)

    unit = "log friction per spread"
    parameters = [Parameter("slope", unit, 0.0, 0.0, LINEAR_SD)] + [
        Parameter(f"bend_{k + 1}", unit, 0.0, 0.0, CURVED_SD) for k in range(max(0, len(knots) - 2))
    ]
    return FrictionEffect(PREFIX + column, tuple(parameters), design=design)


def _curve(column: str, facts: Facts) -> Curve | None:
    if len(facts.get("knots", ())) < 2:
        return None
    knots, centre = np.array(facts["knots"]), facts["centre"]
    x = np.linspace(knots[0], knots[-1], N_PLACES)
    curves = spline_columns(x, knots, centre, facts["scale"])
    state = f"number_column(columns, {column!r})"
    return Curve(
        of=column,
        unit="",
        value="log friction",
        x=x,
        columns=curves - np.mean(curves, axis=0),
        rests=False,
        form="friction",
        state=f"np.nan_to_num({state}, nan={centre:.6g})",
        needs=(column,),
    )


def spline_columns(values: Floats, knots: Floats, centre: float, scale: float) -> Floats:
    """Natural cubic spline basis `[n_events, max(1, n_knots - 1)]`: a line, then departures.

    The truncated power form of Hastie, Tibshirani and Friedman (2009, eq. 5.4-5.5), scaled so
    that each column is of order one.
    """
    line = (values - centre) / scale
    n = len(knots)
    if n < 3:
        return line[:, None]
    span = knots[-1] - knots[0]

    def d(k: int) -> Floats:
        top = np.maximum(values - knots[k], 0.0) ** 3 - np.maximum(values - knots[-1], 0.0) ** 3
        return np.asarray(top / ((knots[-1] - knots[k]) * span**2))

    bends = [8.0 * span / scale * (d(k) - d(n - 2)) for k in range(n - 2)]
    return np.column_stack([line, *bends])


MIDDLE_DAY, HALF_WIDTH = 90.0, 60.0
MIN_DATES = 20


def _winter(columns: EventColumns) -> Floats:
    t = np.nan_to_num((columns.day_of_winter - MIDDLE_DAY) / HALF_WIDTH)
    return np.column_stack([t, t * t])


def _few_days(columns: EventColumns, _sites: Sites) -> str | None:
    days = columns.day_of_winter[np.isfinite(columns.day_of_winter)]
    enough = len(days) >= MIN_DATES and float(np.std(days)) > 5.0
    return None if enough else f"fewer than {MIN_DATES} events have a day (not only a year)"


DRIFT = (
    Parameter("slope", "log friction per 60 days", 0.0, 0.0, 0.2),
    Parameter("bend", "log friction per (60 days)2", 0.0, 0.0, 0.1),
)
SEASON = Definition(
    key="season",
    meaning="The snow changes from winter to spring: cold and dry before, moist and heavy after. "
    "Friction then drifts with the day of the winter (counted from 1 November).",
    needs="date",
    build=lambda _: FrictionEffect("season", DRIFT, _winter),
    lacking=_few_days,
    event_columns=True,
    order=120,
)


SLOPE = Parameter("slope", "log friction per 1000 m", 0.0, 0.0, 0.4)
CENTRE_M = 2000.0
MIN_SPREAD_M = 50.0


def _kilometres(columns: EventColumns) -> Floats:
    z = (columns.release_elevation - CENTRE_M) / 1000.0
    return np.nan_to_num(z)[:, None]


def _one_height(columns: EventColumns, _sites: Sites) -> str | None:
    z = columns.release_elevation[np.isfinite(columns.release_elevation)]
    if len(z) and np.std(z) >= MIN_SPREAD_M:
        return None
    return f"release elevations differ by less than {MIN_SPREAD_M:.0f} m"


RELEASE_ELEVATION = Definition(
    key="release-elevation",
    meaning="Snow is colder and drier the higher it lies. Avalanches that start high then have "
    "another friction than those that start low.",
    needs="release_elevation_m",
    build=lambda _: FrictionEffect("release-elevation", (SLOPE,), _kilometres),
    lacking=_one_height,
    order=110,
)
