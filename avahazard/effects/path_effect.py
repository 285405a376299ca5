"""Paths differ for a reason not recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, GroupEffect
from avahazard.effects.groups import Groups
from avahazard.effects.site import Site
from avahazard.effects.spread import spread_parameter

MIN_PATHS = 5
"""Fewest paths that tell their spread well enough for it to be named or added."""
MIN_DIFFERENT = 2


def _groups(columns: EventColumns) -> Groups:
    return Groups(columns.paths, columns.path_index, told="path:")


def _n_paths(columns: EventColumns) -> int:
    return len(np.unique(columns.path_index[columns.path_index >= 0]))


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    n = _n_paths(columns)
    return None if n >= MIN_PATHS else f"there are {n} paths, fewer than {MIN_PATHS}"


def _as_nuisance(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    return None if _n_paths(columns) >= MIN_DIFFERENT else "there is one path"


def _build(_facts: Facts) -> GroupEffect:
    return GroupEffect("path-effect", (spread_parameter("tau"),), groups=_groups)


DEFINITION = Definition(
    key="path-effect",
    meaning="Each path has a friction of its own, for a reason that no column tells (roughness, "
    "exposure, climate). Its spread between paths is τ, on log friction.",
    needs=f">= {MIN_PATHS} paths",
    build=_build,
    lacking=_lacking,
    nuisance=_as_nuisance,
    granted_unasked=True,
    order=130,
)
