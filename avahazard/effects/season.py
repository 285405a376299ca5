"""Friction changing through the winter."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, FrictionEffect, Parameter, Sites

MIDDLE_DAY, HALF_WIDTH = 90.0, 60.0
MIN_DATES = 20


def _design(columns: EventColumns) -> Floats:
    t = np.nan_to_num((columns.day_of_winter - MIDDLE_DAY) / HALF_WIDTH)
    return np.column_stack([t, t * t])


def _lacking(columns: EventColumns, _sites: Sites) -> str | None:
    days = columns.day_of_winter[np.isfinite(columns.day_of_winter)]
    enough = len(days) >= MIN_DATES and float(np.std(days)) > 5.0
    return None if enough else f"fewer than {MIN_DATES} events have a day (not only a year)"


PARAMETERS = (
    Parameter("slope", "log friction per 60 days", 0.0, 0.0, 0.2),
    Parameter("bend", "log friction per (60 days)2", 0.0, 0.0, 0.1),
)
DEFINITION = Definition(
    key="season",
    meaning="The snow changes from winter to spring: cold and dry before, moist and heavy after. "
    "Friction then drifts with the day of the winter (counted from 1 November).",
    needs="date",
    build=lambda _: FrictionEffect("season", PARAMETERS, _design),
    lacking=_lacking,
    event_columns=True,
    order=120,
)
