"""Friction varies with columns: a smooth of one or its levels, its scatter.

Snow type, channelled and open paths, height and season have names. And with the volume as another
law or scatter says.
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray

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
    known,
    unless,
)
from avahazard.notes import Note
from avahazard.records.meanings import plain_word

PREFIX = "covariate:"
VOLUME, RELEASE, PATH_ID = "volume_m3", "release_elevation_m", "path_id"
VOLUME_PER = f"{VOLUME}_per_"
"""Before the name of a column: the log of the volume's ratio to it."""
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
        uses_volume=in_logs(column),
        beyond=2 if column.startswith(VOLUME_PER) else 1,
        curve=partial(_curve, column),
        names_cause=False,
        column=column,
    )


def _lacking(column: str, columns: EventColumns, _sites: Sites) -> str | None:
    numbers = known_numbers(columns, column)
    if len(numbers) >= MIN_EVENTS and len(np.unique(numbers)) >= 3:
        return None
    return level_lacking(column, columns)


def number_column(columns: EventColumns, name: str) -> Floats | None:
    """A column of numbers by its name in the files, or of a ratio its log; None if there is none.

    Of the volume it is the log as well.
    """
    of_records = {
        VOLUME: columns.log_volume,
        RELEASE: columns.release_elevation,
        "year": columns.year,
        "day_of_winter": columns.day_of_winter,
        "deposit_length_m": columns.deposit_length,
    }
    found = {**columns.made, **columns.numbers, **of_records}.get(name)
    under = columns.numbers.get(name.removeprefix(VOLUME_PER))
    if found is not None or under is None or not name.startswith(VOLUME_PER):
        return found
    return np.asarray(columns.log_volume - np.log(np.where(under > 0.0, under, np.nan)))


def in_logs(name: str) -> bool:
    """Whether a column of numbers is given by its log."""
    return name == VOLUME or name.startswith(VOLUME_PER)


def ratios_to_volume(columns: EventColumns) -> list[str]:
    """The volume over each column of the file whose numbers are all above 0."""
    numbers = columns.numbers.items()
    return [VOLUME_PER + name for name, values in numbers if np.all(known(values) > 0.0)]


def known_numbers(columns: EventColumns, name: str) -> Floats:
    """The numbers that a column has, none where it has texts or is not there."""
    values = number_column(columns, name)
    return np.empty(0) if values is None else known(values)


def line_of(columns: EventColumns, name: str) -> Facts | None:
    """Centre and spread of a column of numbers; None of one that has levels."""
    numbers = known_numbers(columns, name)
    if len(np.unique(numbers)) < 3:
        return None
    return {"centre": float(np.mean(numbers)), "scale": float(np.std(numbers))}


def design_of(name: str, facts: Facts, columns: EventColumns) -> Floats:
    """Columns `[n_events, n]` of a column: its levels, a spline over its knots, or a line.

    A missing number counts as the mean of the column; without the column all are 0. Of numbers
    `over` or `under` a limit: 1 where they are, else 0.
    """
    if "levels" in facts:
        texts = text_column(columns, name)
        there = [""] * len(columns) if texts is None else [plain_word(text) for text in texts]
        of_level = [np.array(there) == plain_word(level) for level in facts["levels"]]
        return np.column_stack(of_level).astype(np.float64)
    numbers, knots = number_column(columns, name), np.array(facts.get("knots", ()))
    if numbers is None:
        return np.zeros((len(columns), max(1, len(knots) - 1)))
    if "over" in facts or "under" in facts:
        there = (numbers > facts.get("over", -np.inf)) & (numbers < facts.get("under", np.inf))
        return np.asarray(there, np.float64)[:, None]
    values = np.where(np.isfinite(numbers), numbers, facts["centre"])
    return spline_columns(values, knots, facts["centre"], facts["scale"])


def smooth_of(columns: EventColumns, name: str) -> Facts | None:
    """Centre, spread and knots of a column of numbers; None of one that has levels."""
    line = line_of(columns, name)
    if line is None:
        return None
    knots = np.unique(np.quantile(known_numbers(columns, name), np.linspace(0.05, 0.95, N_KNOTS)))
    return {"knots": knots.tolist(), **line}


def _facts(column: str, columns: EventColumns, _sites: Sites) -> Facts:
    return smooth_of(columns, column) or level_facts(column, columns)


def bends_of(facts: Facts) -> list[tuple[str, float]]:
    """The departures of a smooth from its line by name, with their prior standard deviation."""
    return [(f"bend_{k + 1}", CURVED_SD) for k in range(len(facts.get("knots", ())) - 2)]


def _build(column: str, facts: Facts) -> FrictionEffect:
    if "levels" in facts:
        return level_effect(PREFIX + column, column, facts)
    parameters = tuple(
        Parameter(name, "log friction per sd", 0.0, 0.0, sd)
        for name, sd in [("slope", LINEAR_SD), *bends_of(facts)]
    )
    return FrictionEffect(PREFIX + column, parameters, partial(design_of, column, facts))


def _curve(column: str, facts: Facts) -> Curve | None:
    if len(facts.get("knots", ())) < 2:
        return None
    knots, centre = np.array(facts["knots"]), facts["centre"]
    x = np.linspace(knots[0], knots[-1], N_PLACES)
    curves = spline_columns(x, knots, centre, facts["scale"])
    return Curve(
        of=column,
        unit="",
        value="log friction",
        x=x,
        columns=curves - np.mean(curves, axis=0),
        form="friction",
        state=f"np.nan_to_num(number_column(columns, {column!r}), nan={centre:.6g})",
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


SCATTERS = 2.5
"""Prior standard deviation of a level's log friction against the most common one, in spreads of
all records: weakly informative (Gelman, Jakulin, Pittau & Su 2008; the default of rstanarm)."""
LEAST_SD = 0.2
"""Least of it, and what it is where the records tell no spread."""
MOST_NAMED = 5
"""Levels that a sentence names."""


def text_column(columns: EventColumns, name: str) -> NDArray[np.str_] | None:
    """A column of text, or of numbers as text; None if there is none."""
    numbers = {**columns.made, **columns.numbers}.get(name)
    if name == PATH_ID:
        return np.array([*columns.paths, ""])[columns.path_index]
    if name == "section" or numbers is None:
        return {**columns.texts, "section": columns.section}.get(name)
    return np.array(["" if np.isnan(v) else f"{v:g}" for v in numbers])


def level_counts(values: NDArray[np.str_]) -> dict[str, int]:
    """Number of events of each level by name, missing ones ('') left out."""
    levels, counts = np.unique(values[values != ""], return_counts=True)
    return {str(k): int(n) for k, n in zip(levels, counts, strict=True)}


def level_lacking(name: str, columns: EventColumns, _sites: Sites = ()) -> str | None:
    """What a column lacks for an effect by level: two levels, each on enough events."""
    values = text_column(columns, name)
    if values is None:
        return f"there is no column {name}"
    if sum(n >= MIN_LEVEL for n in level_counts(values).values()) >= 2:
        return None
    return f"{name} has no two values with at least {MIN_LEVEL} events each"


def level_facts(
    name: str, columns: EventColumns, _sites: Sites = (), most: int | None = None
) -> Facts:
    """The most common level, at most `most` others with enough events, and the prior's width."""
    values = text_column(columns, name)
    assert values is not None
    counts = level_counts(values)
    ranked = sorted(counts, key=counts.__getitem__, reverse=True)
    # The prior's width by the spread of all H/L: more than one level can add.
    ratio = columns.height_over_length[columns.height_over_length > 0.0]
    spread = SCATTERS * float(np.std(np.log(ratio))) if len(ratio) >= 2 * MIN_LEVEL else 0.0
    return {
        "reference": ranked[0],
        "levels": sorted([k for k in ranked[1:] if counts[k] >= MIN_LEVEL][:most]),
        "prior_sd": round(max(LEAST_SD, spread), 3),
    }


def level_text(name: str, columns: EventColumns, _sites: Sites = ()) -> Note | None:
    """How many events, or which paths, have each level, the most common first; None without."""
    values = text_column(columns, name)
    if values is None:
        return None
    counts = level_counts(values)
    ranked = sorted(counts, key=counts.__getitem__, reverse=True)
    on_path = {p: set(values[columns.path_index == k]) for k, p in enumerate(columns.paths)}
    if all(len(own) == 1 for own in on_path.values()) and len(on_path) > 1 and len(ranked) > 1:
        parts = [
            Note("paths_at_level", paths=sorted(p for p in on_path if k in on_path[p]), level=k)
            for k in ranked
        ]
        return Note("level_of_path", column=name, parts=parts)
    first = [f"{counts[k]} {k}" for k in ranked[:MOST_NAMED]]
    rest = len(ranked) - MOST_NAMED
    key = "levels_and_others" if rest > 0 else "levels"
    return Note(key, column=name, events=len(columns), parts=first, n=rest)


def unknown_values(column: str, facts: Facts, columns: EventColumns) -> list[Note]:
    """Notes on the events whose value of a column an effect does not know, or lacks.

    By its `facts` those have no offset: they count as its reference, or as the mean of the column.
    """
    notes, total = [], len(columns)
    if "levels" in facts:
        texts, value = text_column(columns, column), facts["reference"]
        there = [""] * total if texts is None else texts.tolist()
        known = {plain_word(level) for level in ("", value, *facts["levels"])}
        if unknown := sorted({text for text in there if plain_word(text) not in known}):
            notes.append(Note("level_unknown", column, levels=unknown, level=value))
        missing = there.count("")
    else:
        numbers, value = number_column(columns, column), f"{facts['centre']:.4g}"
        missing = total if numbers is None else int(np.sum(~np.isfinite(numbers)))
    if missing:
        notes.append(Note("value_missing", column, n=missing, total=total, level=value))
    return notes


def level_effect(key: str, name: str, facts: Facts) -> FrictionEffect:
    """One offset of log friction for each level but the reference; other levels have none."""
    unit, sd = f"log friction against {facts['reference']}", facts["prior_sd"]
    parameters = tuple(Parameter(level, unit, 0.0, 0.0, sd) for level in facts["levels"])
    return FrictionEffect(key, parameters, partial(design_of, name, facts))


def _by_level(key: str, column: str, meaning: str, order: int, *, of_event: bool) -> Definition:
    return Definition(
        key=key,
        meaning=meaning,
        needs=column,
        build=partial(level_effect, key, column),
        lacking=partial(level_lacking, column),
        facts=partial(level_facts, column),
        seen_in=partial(level_text, column),
        event_columns=of_event,
        column=column if of_event else None,
        order=order,
    )


SNOW_TYPE = _by_level(
    "snow-type",
    "snow_type",
    "Wet, dry and mixed snow rub differently on the bed. Each type has its own level of "
    "friction, given against the most common type.",
    90,
    of_event=True,
)
PATH_SECTION = _by_level(
    "path-section",
    "section",
    "A channel confines the flow and keeps it deep, an open slope lets it spread. The "
    "two kinds of path then have different friction.",
    100,
    of_event=False,
)


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
        facts=lambda columns, _sites: (
            line_of(columns, column) or {"levels": level_facts(column, columns)["levels"]}
        ),
        event_columns=True,
        beyond=1,
    )


def _build_scatter(column: str, facts: Facts) -> ScatterEffect:
    names = facts.get("levels", ["slope"])
    parameters = tuple(Parameter(n, "log of the scatter", 0.0, 0.0, SCATTER_SD) for n in names)
    return ScatterEffect(SCATTER + column, parameters, partial(design_of, column, facts))


MIDDLE_DAY, HALF_WIDTH = 90.0, 60.0
MIN_DATES = 20


def _winter(columns: EventColumns) -> Floats:
    t = np.nan_to_num((columns.day_of_winter - MIDDLE_DAY) / HALF_WIDTH)
    return np.column_stack([t, t * t])


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
    lacking=unless(
        lambda columns: (
            len(known(columns.day_of_winter)) >= MIN_DATES
            and np.nanstd(columns.day_of_winter) > 5.0
        ),
        f"fewer than {MIN_DATES} events have a day (not only a year)",
    ),
    event_columns=True,
    order=120,
)


SLOPE = Parameter("slope", "log friction per 1000 m", 0.0, 0.0, 0.4)
CENTRE_M = 2000.0
MIN_SPREAD_M = 50.0


def _kilometres(columns: EventColumns) -> Floats:
    z = (columns.release_elevation - CENTRE_M) / 1000.0
    return np.nan_to_num(z)[:, None]


RELEASE_ELEVATION = Definition(
    key="release-elevation",
    meaning="Snow is colder and drier the higher it lies. Avalanches that start high then have "
    "another friction than those that start low.",
    needs=RELEASE,
    build=lambda _: FrictionEffect("release-elevation", (SLOPE,), _kilometres),
    lacking=unless(
        lambda columns: (
            len(known(columns.release_elevation)) > 0
            and np.nanstd(columns.release_elevation) >= MIN_SPREAD_M
        ),
        f"release elevations differ by less than {MIN_SPREAD_M:.0f} m",
    ),
    order=110,
)


_NEEDS_VOLUME = unless(
    lambda columns: len(np.unique(known(columns.log_volume))) > 1,
    "the events have no (different) volumes",
)
VOLUME_LAW = Definition(
    key="volume-law",
    meaning="Friction falls with volume along another curve than the model's law. The most "
    "likely of the other laws is taken.",
    needs="volume",
    build=lambda _: Effect("volume-law", ()),
    lacking=_NEEDS_VOLUME,
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
    lacking=_NEEDS_VOLUME,
    changes=Setting("scatter", "the scatter of friction", value="volume"),
    order=80,
)
"""Settings of the model: nothing is built for these two."""
