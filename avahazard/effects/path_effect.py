"""Paths differ for a reason not recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Effect, Facts, Parameter
from avahazard.effects.site import Site

MIN_PATHS = 5


def _groups(columns: EventColumns) -> NDArray[np.int64]:
    return columns.path_index


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    n = len(np.unique(columns.path_index[columns.path_index >= 0]))
    return None if n >= MIN_PATHS else f"there are {n} paths, fewer than {MIN_PATHS}"


def _build(_facts: Facts) -> Effect:
    tau = Parameter("tau", "log friction", 0.0, 0.0, 0.2, 0.0)
    return Effect("path-effect", (tau,), groups=_groups)


DEFINITION = Definition(
    key="path-effect",
    meaning="Each path has a friction of its own, for a reason that no column tells (roughness, "
    "exposure, climate). Its spread between paths is τ, on log friction.",
    needs=f">= {MIN_PATHS} paths",
    build=_build,
    lacking=_lacking,
    granted_first=True,
    order=130,
)
