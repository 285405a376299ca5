"""Zones as pieces of a path, with the uncertainty of where each ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.runout_bounds import spread
from avahazard.hazard.zones.limits import Limits, Rule
from avahazard.results.base import Rows
from avahazard.results.zones import Zone


@dataclass(frozen=True, slots=True, eq=False)
class Exceeded:
    """What is exceeded once in one return period, by posterior draw.

    `runout_x` (m) `[n_parameters]`, inf past the end of the profile; `pressure_kpa`
    `[n_parameters, n_places]`, 0 past the runout. `extrapolated`: the record is too short for the
    return period.
    """

    runout_x: Floats
    pressure_kpa: Floats
    extrapolated: bool = False


def zone_pieces(limits: Limits, x: Floats, exceeded: Mapping[float, Exceeded]) -> Rows[Zone]:
    """Every zone of the limits, the worst first, from its upper to its lower end.

    `x` (m) `[n_places]` run from the release to the end of the profile; `exceeded` is by return
    period. A zone ends at the farthest place where one of its rules, or of a worse zone's, holds:
    what lies above such a place is in the zone too, as the track of an avalanche is, also where a
    steep reach follows a flat one. A zone that no draw in two has begins and ends at one place.
    Ends are medians over the posterior.
    """
    ends = np.full(len(next(iter(exceeded.values())).runout_x), x[0])
    zones = []
    start = float(x[0])
    for zone in limits.zones:
        for rule in zone.rules:
            ends = np.maximum(ends, _farthest(rule, x, exceeded[rule.return_period_years]))
        found = spread(ends)
        end = float(x[-1]) if found.q50 is None else found.q50
        zones.append(
            Zone(
                zone=zone.name,
                color=zone.color,
                from_x_m=start,
                to_x_m=end,
                to_x_q05_m=found.q05,
                to_x_q95_m=found.q95,
                beyond=found.q50 is None,
                extrapolated=any(exceeded[r.return_period_years].extrapolated for r in zone.rules),
            )
        )
        start = end
    return Rows(zones)


def _farthest(rule: Rule, x: Floats, exceeded: Exceeded) -> Floats:
    """The farthest x `[n_parameters]` where the rule holds, x[0] where it never does.

    Pressure is straight between places, and falls to nought at the runout itself.
    """
    runout, pressure = exceeded.runout_x, exceeded.pressure_kpa
    least = rule.pressure_kpa_min
    if least == 0.0:
        return np.asarray(np.maximum(runout, x[0]))
    holds = pressure >= least
    last = len(x) - 1 - np.argmax(holds[:, ::-1], axis=1)
    never = ~holds.any(axis=1)
    draw = np.arange(len(last))
    after = np.minimum(last + 1, len(x) - 1)
    above, below = pressure[draw, last], pressure[draw, after]
    after_x = np.where(below == 0.0, np.minimum(x[after], runout), x[after])
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.clip((above - least) / (above - below), 0.0, 1.0)
    between = x[last] + part * np.maximum(after_x - x[last], 0.0)
    return np.where(never, x[0], np.where(last == len(x) - 1, np.inf, between))
