"""The rows of `hazard` of one path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.row import hazard_row
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.uncertainties import annual_reach, uncertainties
from avahazard.hazard.volume_bounds import volume_bounds
from avahazard.hazard.words import interval_words
from avahazard.inference.seeds import generator
from avahazard.results.hazard import HazardRow, Spread

HELD_WORTH_A_NOTE, HELD_TOO_MANY = 0.05, 0.5
"""Shares of draws that do not start: from the first it is said, from the second no bounds are
given."""
UNKNOWN = Spread(None, None, None, None)


def path_rows(
    path: PathHazard, scenarios: Sequence[Scenario], n_draws: int, seed: int
) -> list[HazardRow]:
    """A row for each scenario of a path (`workflow.hazard`), each from `n_draws` draws.

    The first has `reach`, the annual chance along the path, where the rate is known. A row hangs
    on the seed, its path and its scenario, not on the other rows.
    """
    rows = [_row(path, scenario, n_draws, seed) for scenario in scenarios]
    if path.rate_known:
        rows[0] = replace(rows[0], reach=annual_reach(path))
    return rows


def _row(path: PathHazard, scenario: Scenario, n_draws: int, seed: int) -> HazardRow:
    period = scenario.return_period
    keys = (seed, "hazard", path.path_id, repr(scenario.volume_m3), repr(period))
    bounds = volume_bounds(path, scenario.any_volume_m3, n_draws, generator(*keys))
    notes = []
    held = bounds.p_not_released
    if held > HELD_WORTH_A_NOTE:
        notes.append(
            f"{path.path_id}: the block does not start in {held:.0%} of the draws, since the "
            "slope at its release is under the friction. Give the path a release_elevation_m "
            "on steeper ground."
        )
    if held > HELD_TOO_MANY:
        bounds = replace(bounds, x=UNKNOWN, elevation=UNKNOWN)
    row = hazard_row(scenario, bounds, interval_words(path, return_period=period is not None))
    row = replace(row, notes=tuple(notes))
    if held > HELD_TOO_MANY:
        return row
    apart = uncertainties(path, scenario)
    return replace(row, natural=apart.natural, parameters=apart.parameters, exceeded=apart.exceeded)
