"""One row of the `hazard` result (docs/results.md)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from avahazard.hazard.runout_bounds import RunoutBounds
from avahazard.hazard.volume_frequency import ReturnVolume, VolumeFrequency


def hazard_row(
    path_id: str,
    volume_m3: float | None,
    bounds: RunoutBounds,
    interval: str,
    returned: ReturnVolume | None = None,
    frequency: VolumeFrequency | None = None,
) -> dict[str, Any]:
    """The row as plain values; lengths in m, None where a runout lies beyond the profile.

    `runout_x_steps_m` are the quantiles of x at 5, 10, … 95 %; `interval` says what varies between
    the draws; `returned` and `frequency` tell where the volume of a return period comes from, and
    are left out for a volume that the user gave. Volume is None where the model has no use for it.
    """
    row: dict[str, Any] = {
        "path_id": path_id,
        "return_period_years": returned.return_period_years if returned else None,
        "volume_m3": volume_m3,
        "runout_x_m": asdict(bounds.x),
        "runout_elevation_m": asdict(bounds.elevation),
        "runout_x_steps_m": list(bounds.x_steps),
        "interval": interval,
        "p_left_profile": bounds.p_left_profile,
        "p_not_released": bounds.p_not_released,
        "n_draws": bounds.n_draws,
        "n_nonpositive_friction": bounds.n_nonpositive,
    }
    if returned and frequency:
        row |= {
            "volume_interval_m3": {"q05": returned.q05_m3, "q95": returned.q95_m3},
            "volume_method": frequency.method,
            "volume_source": frequency.source,
            "pooled": frequency.pooled,
            "extrapolated": returned.extrapolated,
        }
        record = frequency.record
        if record is not None:
            row |= {
                "n_records": record.n_events,
                "first_year": record.first_year,
                "last_year": record.last_year,
                "years_not_observed": record.n_unobserved,
                "years_from": record.window,
                "events_per_year": record.events_per_year,
            }
    return row
