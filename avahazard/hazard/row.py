"""One row of `hazard`, from its bounds."""

from __future__ import annotations

from dataclasses import replace

from avahazard.hazard.runout_bounds import RunoutBounds
from avahazard.hazard.scenario import Scenario
from avahazard.results.hazard import HazardRow, VolumeInterval


def hazard_row(scenario: Scenario, bounds: RunoutBounds, interval: str) -> HazardRow:
    """The row of a scenario; `interval` says what varies between the draws.

    Where the volume of a return period comes from is left out for a volume that the user gave.
    """
    row = HazardRow(
        path_id=scenario.path_id,
        return_period_years=scenario.return_period,
        volume_m3=scenario.volume_m3,
        runout_x_m=bounds.x,
        runout_elevation_m=bounds.elevation,
        runout_x_steps_m=bounds.x_steps,
        interval=interval,
        p_left_profile=bounds.p_left_profile,
        p_not_released=bounds.p_not_released,
        n_draws=bounds.n_draws,
        n_nonpositive_friction=bounds.n_nonpositive,
    )
    returned, frequency = scenario.returned, scenario.frequency
    if returned is None or frequency is None:
        return row
    row = replace(
        row,
        volume_interval_m3=VolumeInterval(returned.q05_m3, returned.q95_m3),
        volume_method=frequency.method,
        volume_source=frequency.source,
        pooled=frequency.pooled,
        extrapolated=returned.extrapolated,
    )
    record = frequency.record
    if record is None:
        return row
    return replace(
        row,
        n_records=record.n_events,
        first_year=record.first_year,
        last_year=record.last_year,
        years_not_observed=record.n_unobserved,
        years_from=record.window,
        events_per_year=record.events_per_year,
    )
