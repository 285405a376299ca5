"""Zones as pieces of a path, with the uncertainty of where each ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.runout_bounds import spread
from avahazard.hazard.zones.limits import Limits, Rule

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Exceeded:
    """What is exceeded once in one return period, by posterior draw.

    `runout_x` (m) `[n_parameters]`, inf past the end of the profile; `pressure_kpa`
    `[n_parameters, n_places]`, 0 past the runout.
    """

    runout_x: Floats
    pressure_kpa: Floats


@dataclass(frozen=True, slots=True)
class ZonePiece:
    """A zone from `from_x` to `to_x` (m), both medians over the posterior.

    `to_x` is the end of the profile where the zone goes on `beyond` it; `to_x_q05`, `to_x_q95`
    are None where they lie beyond it.
    """

    name: str
    color: str
    from_x: float
    to_x: float
    to_x_q05: float | None
    to_x_q95: float | None
    beyond: bool


def zone_pieces(
    limits: Limits, x: Floats, exceeded: Mapping[float, Exceeded]
) -> tuple[ZonePiece, ...]:
    """Every zone of the limits, the worst first, from its upper to its lower end.

    `x` (m) `[n_places]` run from the release to the end of the profile; `exceeded` is by return
    period. A zone ends at the farthest place where one of its rules, or of a worse zone's, holds:
    what lies above such a place is in the zone too, as the track of an avalanche is, also where a
    steep reach follows a flat one. A zone that no draw in two has begins and ends at one place.
    """
    ends = np.full(len(next(iter(exceeded.values())).runout_x), x[0])
    pieces = []
    start = float(x[0])
    for zone in limits.zones:
        for rule in zone.rules:
            ends = np.maximum(ends, _farthest(rule, x, exceeded[rule.return_period_years]))
        found = spread(ends)
        end = float(x[-1]) if found.q50 is None else found.q50
        pieces.append(
            ZonePiece(zone.name, zone.color, start, end, found.q05, found.q95, found.q50 is None)
        )
        start = end
    return tuple(pieces)


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
