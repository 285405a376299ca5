"""The effect of one column depends on another, or on the volume."""

from __future__ import annotations

from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import LINEAR_SD, VOLUME, number_column
from avahazard.effects.effect import MIN_LEVEL, Definition, Facts, FrictionEffect, Parameter, Sites
from avahazard.effects.levels import LEAST_SD, level_facts, level_lacking, text_column

PREFIX = "interaction:"
MOST_LEVELS = 4
"""Levels of a column that are told apart beside another."""


def interaction(pair: str) -> Definition:
    """The effect of `A*B`, two columns, the second perhaps `volume_m3`."""
    one, _, other = pair.partition("*")
    return Definition(
        key=PREFIX + pair,
        meaning=f"What {one} does to friction depends on {other}: it matters for some avalanches "
        "and not for others. Both columns and their product are fitted.",
        needs=f"columns {one} and {other}",
        build=partial(_build, one, other),
        lacking=partial(_lacking, one, other),
        facts=partial(_facts, one, other),
        event_columns=True,
        uses_volume=VOLUME in (one, other),
        beyond=2,
    )


def _lacking(one: str, other: str, columns: EventColumns, sites: Sites) -> str | None:
    facts = _facts(one, other, columns, sites)
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


def _facts(one: str, other: str, columns: EventColumns, _sites: Sites) -> Facts:
    """Of each column its levels, or centre and spread; left out where it tells nothing."""
    found: Facts = {}
    for name in (one, other):
        values = number_column(columns, name)
        known = np.empty(0) if values is None else values[np.isfinite(values)]
        if len(np.unique(known)) > 2:
            found[name] = {"centre": float(np.mean(known)), "scale": float(np.std(known))}
        elif level_lacking(name, columns) is None:
            found[name] = {"levels": level_facts(name, columns)["levels"][:MOST_LEVELS]}
    return found


def _part(name: str, facts: Facts, columns: EventColumns) -> Floats:
    """Columns `[n_events, n]` of one of the two: a line of a number, or its levels."""
    if "levels" in facts:
        values = text_column(columns, name)
        if values is None:
            return np.zeros((len(columns), len(facts["levels"])))
        of_level = [values == level for level in facts["levels"]]
        return np.asarray(np.column_stack(of_level), np.float64)
    numbers = number_column(columns, name)
    if numbers is None:
        return np.zeros((len(columns), 1))
    return np.asarray(np.nan_to_num((numbers - facts["centre"]) / facts["scale"])[:, None])


def _products(first: Floats, second: Floats) -> Floats:
    return np.asarray((first[:, :, None] * second[:, None, :]).reshape(len(first), -1))


def _build(one: str, other: str, facts: Facts) -> FrictionEffect:
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
    return FrictionEffect(f"{PREFIX}{one}*{other}", parameters, design=design)
