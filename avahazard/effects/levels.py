"""Friction by the levels of a column of text: by snow type, and of channelled and open paths."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import MIN_LEVEL, Definition, Facts, FrictionEffect, Parameter, Sites
from avahazard.notes import Note

SCATTERS = 2.5
"""Prior standard deviation of a level's log friction against the most common one, in spreads of
all records: weakly informative (Gelman, Jakulin, Pittau & Su 2008; the default of rstanarm)."""
LEAST_SD = 0.2
"""Least of it, and what it is where the records tell no spread."""
MOST_LEVELS = 5
"""Levels that a sentence names."""


def text_column(columns: EventColumns, name: str) -> NDArray[np.str_] | None:
    """A column of text, or of numbers as text; None if there is none."""
    if name == "section":
        return columns.section
    numbers = columns.numbers.get(name, columns.made.get(name))
    if numbers is not None:
        return np.array(["" if np.isnan(v) else f"{v:g}" for v in numbers])
    return columns.texts.get(name)


def level_columns(columns: EventColumns, name: str, levels: Sequence[object]) -> Floats:
    """1 where the column has a level, `[n_events, n_levels]`; 0 everywhere without the column."""
    values = text_column(columns, name)
    if values is None:
        return np.zeros((len(columns), len(levels)))
    return np.column_stack([values == level for level in levels]).astype(np.float64)


def level_counts(values: NDArray[np.str_]) -> dict[str, int]:
    """Number of events of each level, missing ones ('') left out."""
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


def level_facts(name: str, columns: EventColumns, _sites: Sites = ()) -> Facts:
    """The most common level, the others with enough events, and the prior's width for these."""
    values = text_column(columns, name)
    assert values is not None
    counts = level_counts(values)
    ranked = sorted(counts, key=lambda k: (-counts[k], k))
    return {
        "reference": ranked[0],
        "levels": sorted(k for k in ranked[1:] if counts[k] >= MIN_LEVEL),
        "prior_sd": _prior_sd(columns),
    }


def _prior_sd(columns: EventColumns) -> float:
    """Prior standard deviation of a level's log friction, by how much that of all records spreads.

    H/L is the friction of a block on a straight line, whatever the model. What spreads it (volume,
    path, scatter, the levels themselves) is more than a level can be expected to add.
    """
    known = columns.height_over_length[columns.height_over_length > 0.0]
    if len(known) < 2 * MIN_LEVEL:
        return LEAST_SD
    return round(max(LEAST_SD, SCATTERS * float(np.std(np.log(known)))), 3)


def level_words(name: str, columns: EventColumns, _sites: Sites = ()) -> Note | None:
    """How many events, or for what a path has which paths, have each level; None without a column.

    The most common level stands first.
    """
    values = text_column(columns, name)
    if values is None:
        return None
    counts = level_counts(values)
    ranked = sorted(counts, key=lambda k: (-counts[k], k))
    of_path = all(len(set(values[columns.path_index == k])) == 1 for k in range(len(columns.paths)))
    if of_path and len(columns.paths) > 1 and len(ranked) > 1:
        paths = np.array(columns.paths)
        level = np.array([values[columns.path_index == k][0] for k in range(len(columns.paths))])
        parts = [
            Note("paths_at_level", paths=sorted(paths[level == k].tolist()), level=k)
            for k in ranked
        ]
        return Note("level_of_path", column=name, parts=parts)
    first = [f"{counts[k]} {k}" for k in ranked[:MOST_LEVELS]]
    rest = len(ranked) - MOST_LEVELS
    key = "levels_and_others" if rest > 0 else "levels"
    return Note(key, column=name, events=len(columns), parts=first, n=rest)


def level_effect(key: str, name: str, facts: Facts) -> FrictionEffect:
    """One offset of log friction for each level but the reference; other levels have none."""
    levels = [str(k) for k in facts["levels"]]
    # Models stored before the width was taken from the data have none.
    sd = float(facts.get("prior_sd", LEAST_SD))

    unit = f"log friction against {facts['reference']}"
    parameters = tuple(Parameter(level, unit, 0.0, 0.0, sd) for level in levels)
    return FrictionEffect(key, parameters, lambda columns: level_columns(columns, name, levels))


def _by_level(key: str, column: str, meaning: str, order: int, *, of_event: bool) -> Definition:
    """The effect `key` of a column."""
    return Definition(
        key=key,
        meaning=meaning,
        needs=column,
        build=partial(level_effect, key, column),
        lacking=partial(level_lacking, column),
        facts=partial(level_facts, column),
        seen_in=partial(level_words, column),
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
