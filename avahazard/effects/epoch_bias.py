"""Records before some year are shifted."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import MIN_LEVEL, Definition, Facts, Parameter, ShiftEffect, Sites

EDGE_YEARS = 4.0
"""The change is blurred over these years, so that the likelihood is smooth in its date."""


def _shift(columns: EventColumns, values: Floats) -> Floats:
    shift, year = values
    before = np.clip((year - columns.year) / EDGE_YEARS + 0.5, 0.0, 1.0)
    return np.asarray(shift * np.nan_to_num(before))


def _lacking(columns: EventColumns, _sites: Sites) -> str | None:
    years = columns.year[np.isfinite(columns.year)]
    if len(years) >= 4 * MIN_LEVEL and np.ptp(years) >= 20:
        return None
    return "fewer than 20 dated events over 20 years"


def _facts(columns: EventColumns, _sites: Sites) -> Facts:
    years = columns.year[np.isfinite(columns.year)]
    return {
        "years": [float(q) for q in np.unique(np.quantile(years, np.linspace(0.1, 0.9, 9)).round())]
    }


def _build(facts: Facts) -> ShiftEffect:
    years = tuple(float(y) for y in facts["years"])
    middle = years[len(years) // 2]
    return ShiftEffect(
        "epoch-bias",
        (
            Parameter("shift", "m", 0.0, 0.0, 40.0, -160.0, 160.0),
            Parameter("before", "year", middle, middle, 50.0, years[0], years[-1]),
        ),
        shift=_shift,
    )


DEFINITION = Definition(
    key="epoch-bias",
    meaning="Old records were made differently (from hearsay, from the valley, to the reach of "
    "the powder). Before some year they lie systematically too high or too low.",
    needs="date",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    order=150,
)
