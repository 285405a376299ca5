"""Short runouts were not seen."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    MIN_LEVEL,
    Definition,
    Facts,
    LimitEffect,
    Parameter,
    Sites,
    needs_profile,
)

FAR_M = 1000.0
"""A limit this far above the highest stop seen is no limit."""


def _facts(columns: EventColumns, sites: Sites) -> Facts:
    highest = {}
    for k, site in enumerate(sites):
        stops = columns.stop_elevation[columns.path_index == k]
        stops = stops[np.isfinite(stops)]
        declared = site.path.observed_below_m
        if declared is not None:
            highest[site.path.path_id] = {"declared_m": declared}
        elif len(stops):
            highest[site.path.path_id] = {"highest_m": float(np.max(stops))}
    return {"paths": highest}


def _lacking(columns: EventColumns, sites: Sites) -> str | None:
    known = columns.path_index[columns.path_index >= 0]
    if any(sites[k].path.observed_below_m is not None for k in np.unique(known)):
        return None
    # The highest of very few stops is where these stopped, and no limit.
    stops = columns.path_index[np.isfinite(columns.stop_elevation)]
    if np.max(np.bincount(stops[stops >= 0], minlength=1)) >= MIN_LEVEL:
        return None
    lack = f"no path has {MIN_LEVEL} stops with an elevation, or a declared limit"
    return needs_profile(columns, sites) or lack


def _settled(columns: EventColumns, sites: Sites) -> bool:
    known = columns.path_index[columns.path_index >= 0]
    return all(sites[k].path.observed_below_m is not None for k in np.unique(known))


def _build(facts: Facts) -> LimitEffect:
    paths: dict[str, dict[str, float]] = facts["paths"]

    def limit(columns: EventColumns, values: Floats) -> Floats:
        result = np.full(len(columns), np.nan)
        for i, k in enumerate(columns.path_index):
            known = paths.get(columns.paths[k], {}) if k >= 0 else {}
            if "declared_m" in known:
                result[i] = known["declared_m"]
            elif "highest_m" in known and values[0] < FAR_M:
                result[i] = known["highest_m"] + values[0]
        return result

    margin = Parameter("margin", "m above the highest stop seen", FAR_M, 200.0, 400.0, 0.0, FAR_M)
    return LimitEffect("observation-limit", (margin,), limit=limit)


DEFINITION = Definition(
    key="observation-limit",
    meaning="Only avalanches that came low enough were seen and written down. The many short "
    "ones are missing, so friction looks lower than it is; the likelihood is divided by the "
    "chance to be seen.",
    needs="observed_below_m, or estimated",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    settled=_settled,
    says_what_is_seen=True,
    order=140,
)
