"""Friction changing with release elevation."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, FrictionEffect, Parameter, Sites

SLOPE = Parameter("slope", "log friction per 1000 m", 0.0, 0.0, 0.4)
CENTRE_M = 2000.0
MIN_SPREAD_M = 50.0


def _design(columns: EventColumns) -> Floats:
    z = (columns.release_elevation - CENTRE_M) / 1000.0
    return np.nan_to_num(z)[:, None]


def _lacking(columns: EventColumns, _sites: Sites) -> str | None:
    z = columns.release_elevation[np.isfinite(columns.release_elevation)]
    if len(z) and np.std(z) >= MIN_SPREAD_M:
        return None
    return f"release elevations differ by less than {MIN_SPREAD_M:.0f} m"


DEFINITION = Definition(
    key="release-elevation",
    meaning="Snow is colder and drier the higher it lies. Avalanches that start high then have "
    "another friction than those that start low.",
    needs="release_elevation_m",
    build=lambda _: FrictionEffect("release-elevation", (SLOPE,), _design),
    lacking=_lacking,
    order=110,
)
