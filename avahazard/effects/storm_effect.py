"""Avalanches of one storm share their snow."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, GroupEffect
from avahazard.effects.groups import MIN_SHARED, Groups, indices
from avahazard.effects.site import Site
from avahazard.effects.spread import spread_parameter

DAYS = 3
"""A storm is what falls within so many days of its first avalanche, on the paths of one location.
It is counted from the first, not from one to the next, or a busy winter would be one storm."""


def _storms(columns: EventColumns) -> list[list[object]]:
    """Location and ordinal of the first day of each storm of two events or more."""
    found: list[list[object]] = []
    for place in np.unique(columns.location):
        days = np.sort(columns.day[(columns.location == place) & np.isfinite(columns.day)])
        while len(days):
            within = days <= days[0] + DAYS
            if np.sum(within) > 1:
                found.append([str(place), int(days[0])])
            days = days[~within]
    return found


def _name(place: str, day: int) -> str:
    return f"storm:{date.fromordinal(day).isoformat()} {place}".strip()


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    if len(_storms(columns)) >= MIN_SHARED:
        return None
    return f"fewer than {MIN_SHARED} times did two avalanches fall within {DAYS} days"


def _facts(columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    return {"storms": _storms(columns)}


def _build(facts: Facts) -> GroupEffect:
    storms = [(str(place), int(day)) for place, day in facts["storms"]]
    names = tuple(_name(*storm) for storm in storms)
    known = {(place, day + k): _name(place, day) for place, day in storms for k in range(DAYS + 1)}

    def groups(columns: EventColumns) -> Groups:
        places = zip(columns.location, np.nan_to_num(columns.day, nan=-1.0), strict=True)
        labels = [known.get((str(place), int(day)), "") for place, day in places]
        return Groups(names, indices(labels, names), alone=True)

    return GroupEffect("storm-effect", (spread_parameter("tau_storm"),), groups=groups)


DEFINITION = Definition(
    key="storm-effect",
    meaning=f"Avalanches that fall within {DAYS} days at one location share their snow, in a way "
    "that no column tells. The spread between storms is τ, on log friction.",
    needs="date",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    nuisance=_lacking,
    order=134,
)
