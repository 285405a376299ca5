"""Friction varies with columns: a smooth of one, one by another, its scatter; height, season.

It changes at a date: on one path (a dam, a forest gone), or on all. And with the volume as another
law or scatter says.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    MIN_LEVEL,
    Curve,
    Definition,
    Effect,
    Facts,
    FrictionEffect,
    Parameter,
    ScatterEffect,
    Setting,
    Sites,
)
from avahazard.effects.groups import (
    LEAST_SD,
    level_columns,
    level_effect,
    level_facts,
    level_lacking,
)

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
    known = _known(columns, column)
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


def _known(columns: EventColumns, name: str) -> Floats:
    """The numbers that a column has, none where it has texts or is not there."""
    values = number_column(columns, name)
    return np.empty(0) if values is None else values[np.isfinite(values)]


def _line_facts(known: Floats) -> Facts:
    return {"centre": float(np.mean(known)), "scale": float(np.std(known))}


def _part(name: str, facts: Facts, columns: EventColumns) -> Floats:
    """Columns `[n_events, n]` of a column: a line of a number, or its levels."""
    if "levels" in facts:
        return level_columns(columns, name, facts["levels"])
    numbers = number_column(columns, name)
    if numbers is None:
        return np.zeros((len(columns), 1))
    return np.asarray(np.nan_to_num((numbers - facts["centre"]) / facts["scale"])[:, None])


def _facts(column: str, columns: EventColumns, _sites: Sites) -> Facts:
    known = _known(columns, column)
    if len(np.unique(known)) < 3:
        return level_facts(column, columns)
    knots = np.unique(np.quantile(known, np.linspace(0.05, 0.95, N_KNOTS)))
    return {"knots": [float(k) for k in knots], **_line_facts(known)}


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


INTERACTION = "interaction:"
MOST_LEVELS = 4
"""Levels of a column that are distinguished beside another."""


def interaction(pair: str) -> Definition:
    """The effect of `A*B`, two columns, the second perhaps `volume_m3`."""
    one, _, other = pair.partition("*")
    return Definition(
        key=INTERACTION + pair,
        meaning=f"What {one} does to friction depends on {other}: it matters for some avalanches "
        "and not for others. Both columns and their product are fitted.",
        needs=f"columns {one} and {other}",
        build=partial(_build_pair, one, other),
        lacking=partial(_lacking_pair, one, other),
        facts=partial(_facts_pair, one, other),
        event_columns=True,
        uses_volume=VOLUME in (one, other),
        beyond=2,
    )


def _lacking_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> str | None:
    facts = _facts_pair(one, other, columns, sites)
    for name in (one, other):
        if name not in facts:
            return f"{name} has no two values with at least {MIN_LEVEL} events each"
    first, second = (_part(name, facts[name], columns) for name in (one, other))
    both = _products(first, second)
    alone = np.column_stack([np.ones(len(columns)), first, second])
    both -= alone @ np.linalg.lstsq(alone, both, rcond=None)[0]
    if np.sum(np.any(np.abs(both) > 1e-6, axis=1)) < 4 * MIN_LEVEL:
        return f"{one} and {other} do not vary apart from each other"
    return None


def _facts_pair(one: str, other: str, columns: EventColumns, _sites: Sites) -> Facts:
    """Of each column its levels, or centre and spread; left out where it has no information."""
    found: Facts = {}
    for name in (one, other):
        known = _known(columns, name)
        if len(np.unique(known)) > 2:
            found[name] = _line_facts(known)
        elif level_lacking(name, columns) is None:
            found[name] = {"levels": level_facts(name, columns)["levels"][:MOST_LEVELS]}
    return found


def _products(first: Floats, second: Floats) -> Floats:
    return np.asarray((first[:, :, None] * second[:, None, :]).reshape(len(first), -1))


def _build_pair(one: str, other: str, facts: Facts) -> FrictionEffect:
    names = {name: facts[name].get("levels", [""]) for name in (one, other)}
    alone = [name for name in (one, other) if name != VOLUME]

    def design(columns: EventColumns) -> Floats:
        parts = {name: _part(name, facts[name], columns) for name in names}
        products = _products(parts[one], parts[other])
        return np.column_stack([*(parts[name] for name in alone), products])

    def label(name: str, level: object) -> str:
        return f"{name}={level}" if level != "" else name

    labels = [(label(n, x), "levels" in facts[n]) for n in alone for x in names[n]]
    labels += [
        (f"{label(one, a)}*{label(other, b)}", "levels" in facts[one] or "levels" in facts[other])
        for a in names[one]
        for b in names[other]
    ]
    parameters = tuple(
        Parameter(text, "log friction", 0.0, 0.0, LEAST_SD if level else LINEAR_SD)
        for text, level in labels
    )
    return FrictionEffect(f"{INTERACTION}{one}*{other}", parameters, design=design)


SCATTER = "scatter:"
SCATTER_SD = 0.5
"""Prior standard deviation of the log of the scatter, of a level or over one spread of a number."""


def scatter_by(column: str) -> Definition:
    """The effect of one column on the scatter."""
    return Definition(
        key=SCATTER + column,
        meaning=f"Avalanches differ more from each other for some values of {column} than for "
        "others. The mean stays, the intervals change.",
        needs=f"column {column}",
        build=partial(_build_scatter, column),
        lacking=partial(_lacking, column),
        facts=partial(_scatter_facts, column),
        event_columns=True,
        beyond=1,
    )


def _scatter_facts(column: str, columns: EventColumns, _sites: Sites) -> Facts:
    known = _known(columns, column)
    if len(np.unique(known)) < 3:
        return {"levels": level_facts(column, columns)["levels"]}
    return _line_facts(known)


def _build_scatter(column: str, facts: Facts) -> ScatterEffect:
    names = [str(level) for level in facts.get("levels", ["slope"])]
    parameters = tuple(Parameter(n, "log of the scatter", 0.0, 0.0, SCATTER_SD) for n in names)
    return ScatterEffect(SCATTER + column, parameters, partial(_part, column, facts))


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


CHANGE, ALL = "change:", "all"
CHANGE_SD = 0.2
MOST_DATES = 40
"""Dates that are tried, evenly among the events."""


def change(path: str) -> Definition:
    """The effect of a change on a path, or on `all`."""
    where = "all paths" if path == ALL else f"path {path}"
    return Definition(
        key=CHANGE + path,
        meaning=f"From some date on friction on {where} is another: something was built or taken "
        "away, or records were made otherwise. The date is the one that the data tell best.",
        needs="date",
        build=partial(_build_change, path),
        lacking=partial(_lacking_change, path),
        facts=partial(_facts_change, path),
        alternatives=partial(_alternatives, path),
        event_columns=True,
        beyond=1,
    )


def _time(columns: EventColumns) -> Floats:
    """Years `[n_events]`, of a day where it is known."""
    return np.where(np.isfinite(columns.day), columns.day / 365.2425 + 1.0, columns.year)


def _there(path: str, columns: EventColumns) -> np.ndarray:
    if path == ALL:
        return np.ones(len(columns), dtype=np.bool_)
    index = columns.paths.index(path) if path in columns.paths else -2
    return np.asarray(columns.path_index == index)


def _alternatives(path: str, columns: EventColumns, _sites: Sites) -> list[Facts]:
    """The dates that are tried: between events, with enough of them on either side."""
    time = _time(columns)
    known = np.sort(time[_there(path, columns) & np.isfinite(time)])
    between = 0.5 * (known[1:] + known[:-1])[MIN_LEVEL - 1 : len(known) - MIN_LEVEL]
    between = between[np.diff(known)[MIN_LEVEL - 1 : len(known) - MIN_LEVEL] > 0.0]
    if len(between) > MOST_DATES:
        between = between[np.linspace(0, len(between) - 1, MOST_DATES).round().astype(int)]
    return [{"from_year": round(float(t), 3)} for t in between]


def _lacking_change(path: str, columns: EventColumns, sites: Sites) -> str | None:
    if _alternatives(path, columns, sites):
        return None
    return f"fewer than {2 * MIN_LEVEL} dated events"


def _facts_change(path: str, columns: EventColumns, sites: Sites) -> Facts:
    """The date that parts H/L best, volume and path taken off (least squares)."""
    tried, time = _alternatives(path, columns, sites), _time(columns)
    known = columns.height_over_length > 0.0
    use = known & np.isfinite(time)
    ratio = np.log(columns.height_over_length[use])
    volume = np.nan_to_num(columns.log_volume[use], nan=float(np.nanmean(columns.log_volume)))
    groups = columns.path_index[use, None] == np.unique(columns.path_index[use])
    rest = np.column_stack([groups, volume]).astype(np.float64)

    def left(facts: Facts) -> float:
        after = (_there(path, columns) & (time >= facts["from_year"]))[use]
        design = np.column_stack([rest, after])
        return float(np.sum((ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]) ** 2))

    return min(tried, key=left)


def _build_change(path: str, facts: Facts) -> FrictionEffect:
    def design(columns: EventColumns) -> Floats:
        # What has no date is to come.
        after = ~(_time(columns) < facts["from_year"])
        return np.asarray(after & _there(path, columns), np.float64)[:, None]

    parameter = Parameter("change", "log friction", 0.0, 0.0, CHANGE_SD)
    paths = () if path == ALL else (path,)
    return FrictionEffect(CHANGE + path, (parameter,), design=design, paths=paths)


def _needs_volume(columns: EventColumns, _sites: Sites) -> str | None:
    known = columns.log_volume[np.isfinite(columns.log_volume)]
    return None if len(known) and np.ptp(known) > 0 else "the events have no (different) volumes"


VOLUME_LAW = Definition(
    key="volume-law",
    meaning="Friction falls with volume along another curve than the model's law. The most "
    "likely of the other laws is taken.",
    needs="volume",
    build=lambda _: Effect("volume-law", ()),
    lacking=_needs_volume,
    changes=Setting("law", "the law of friction against volume"),
    order=70,
)
VOLUME_SCATTER = Definition(
    key="volume-scatter",
    meaning="Large avalanches differ less from each other than small ones do (or more), so the "
    "scatter of friction is σ(V) = a' exp(-n' V), up to the volume that nine events in ten stay "
    "under and constant beyond. The mean stays, the intervals change.",
    needs="volume",
    build=lambda _: Effect("volume-scatter", ()),
    lacking=_needs_volume,
    changes=Setting("scatter", "the scatter of friction", value="volume"),
    order=80,
)
"""Settings of the model: nothing is built for these two."""
