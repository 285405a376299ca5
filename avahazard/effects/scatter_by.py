"""The scatter of friction differs by a column."""

from __future__ import annotations

from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import number_column
from avahazard.effects.effect import Definition, Facts, Parameter, ScatterEffect, Sites
from avahazard.effects.levels import level_facts, level_lacking, text_column

PREFIX = "scatter:"
SD = 0.5
"""Prior standard deviation of the log of the scatter, of a level or over one spread of a number."""
FEWEST = 20


def scatter_by(column: str) -> Definition:
    """The effect of one column on the scatter."""
    return Definition(
        key=PREFIX + column,
        meaning=f"Avalanches differ more from each other for some values of {column} than for "
        "others. The mean stays, the intervals change.",
        needs=f"column {column}",
        build=partial(_build, column),
        lacking=partial(_lacking, column),
        facts=partial(_facts, column),
        event_columns=True,
        beyond=1,
    )


def _lacking(column: str, columns: EventColumns, _sites: Sites) -> str | None:
    values = number_column(columns, column)
    known = np.empty(0) if values is None else values[np.isfinite(values)]
    if len(known) >= FEWEST and len(np.unique(known)) >= 3:
        return None
    return level_lacking(column, columns)


def _facts(column: str, columns: EventColumns, _sites: Sites) -> Facts:
    values = number_column(columns, column)
    known = np.empty(0) if values is None else values[np.isfinite(values)]
    if len(np.unique(known)) < 3:
        return {"levels": level_facts(column, columns)["levels"]}
    return {"centre": float(np.mean(known)), "scale": float(np.std(known))}


def _build(column: str, facts: Facts) -> ScatterEffect:
    levels = facts.get("levels")

    def design(columns: EventColumns) -> Floats:
        if levels is not None:
            texts = text_column(columns, column)
            if texts is None:
                return np.zeros((len(columns), len(levels)))
            return np.asarray(np.column_stack([texts == level for level in levels]), np.float64)
        values = number_column(columns, column)
        if values is None:
            return np.zeros((len(columns), 1))
        return np.asarray(np.nan_to_num((values - facts["centre"]) / facts["scale"])[:, None])

    names = ["slope"] if levels is None else [str(level) for level in levels]
    parameters = tuple(Parameter(n, "log of the scatter", 0.0, 0.0, SD) for n in names)
    return ScatterEffect(PREFIX + column, parameters, design=design)
