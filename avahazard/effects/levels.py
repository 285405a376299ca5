"""Friction by the levels of a column of text: shared by effects on categories."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Effect, Facts, Floats, Parameter
from avahazard.effects.needs import MIN_LEVEL, level_counts, two_levels

LEVEL_SD = 0.2
"""Prior standard deviation of a level's log friction against the most common level."""


def text_column(columns: EventColumns, name: str) -> NDArray[np.str_] | None:
    """A column of text, or of numbers as text; None if there is none."""
    if name == "section":
        return columns.section
    if name in columns.numbers:
        return np.array(["" if np.isnan(v) else f"{v:g}" for v in columns.numbers[name]])
    return columns.texts.get(name)


def level_lacking(columns: EventColumns, name: str) -> str | None:
    """What a column lacks for an effect by level."""
    values = text_column(columns, name)
    return f"there is no column {name}" if values is None else two_levels(name, values)


def level_facts(columns: EventColumns, name: str) -> Facts:
    """The most common level, and the others with enough events to have a parameter."""
    values = text_column(columns, name)
    assert values is not None
    counts = level_counts(values)
    ranked = sorted(counts, key=lambda k: (-counts[k], k))
    return {
        "reference": ranked[0],
        "levels": sorted(k for k in ranked[1:] if counts[k] >= MIN_LEVEL),
    }


def level_effect(key: str, name: str, facts: Facts) -> Effect:
    """One offset of log friction for each level but the reference; other levels have none."""
    levels = [str(k) for k in facts["levels"]]

    def design(columns: EventColumns) -> Floats:
        values = text_column(columns, name)
        if values is None:
            return np.zeros((len(columns), len(levels)))
        return np.column_stack([values == k for k in levels]).astype(np.float64)

    parameters = tuple(
        Parameter(k, f"log friction against {facts['reference']}", 0.0, 0.0, LEVEL_SD)
        for k in levels
    )
    return Effect(key, parameters, design=design)
