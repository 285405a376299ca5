"""Winters differ for a reason not recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, GroupEffect
from avahazard.effects.groups import MIN_SHARED, Groups, indices, shared
from avahazard.effects.site import Site
from avahazard.effects.spread import spread_parameter


def _labels(columns: EventColumns) -> list[str]:
    return ["" if np.isnan(year) else f"winter:{year:.0f}" for year in columns.winter]


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    if len(shared(_labels(columns))) >= MIN_SHARED:
        return None
    return f"fewer than {MIN_SHARED} winters have two events or more"


def _facts(columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    return {"winters": shared(_labels(columns))}


def _build(facts: Facts) -> GroupEffect:
    names = tuple(facts["winters"])

    def groups(columns: EventColumns) -> Groups:
        return Groups(names, indices(_labels(columns), names), alone=True)

    return GroupEffect("winter-effect", (spread_parameter("tau_winter"),), groups=groups)


DEFINITION = Definition(
    key="winter-effect",
    meaning="Avalanches of one winter (October to September) share something that no column "
    "tells, such as its weather or its observer. The spread between winters is τ, on log friction.",
    needs="date",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    nuisance=_lacking,
    order=132,
)
