"""The rows of `hazard` of one path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.hazard.design import design
from avahazard.hazard.notes import row_notes
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.row import hazard_row
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.uncertainties import annual_reach, uncertainties
from avahazard.hazard.volume_bounds import volume_bounds
from avahazard.hazard.words import interval_words
from avahazard.inference.seeds import generator
from avahazard.results.hazard import HazardRow, Spread

HELD_TOO_MANY = 0.5
"""Share of draws that do not start from which no bounds are given."""
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
    held = bounds.p_not_released > HELD_TOO_MANY
    if held:
        bounds = replace(bounds, x=UNKNOWN, elevation=UNKNOWN)
    row = hazard_row(scenario, bounds, interval_words(path, return_period=period is not None))
    if not held:
        apart = uncertainties(path, scenario)
        row = replace(
            row,
            design=None if period is None else design(path, period),
            natural=apart.natural,
            parameters=apart.parameters,
        )
    return replace(row, notes=row_notes(path, row))
