"""One row of the `hazard` result (contract, section 3)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from avahazard.hazard.runout_bounds import RunoutBounds
from avahazard.hazard.volume_frequency import ReturnVolume


def hazard_row(
    path_id: str,
    volume_m3: float,
    bounds: RunoutBounds,
    interval: str,
    returned: ReturnVolume | None = None,
    method: str | None = None,
) -> dict[str, Any]:
    """The row as plain values; lengths in m, None where a runout lies beyond the profile.

    `interval` says what varies between the draws; `returned` and `method` tell where the volume of
    a return period comes from, and are left out for a volume that the user gave.
    """
    row: dict[str, Any] = {
        "path_id": path_id,
        "return_period_years": returned.return_period_years if returned else None,
        "volume_m3": volume_m3,
        "runout_x_m": asdict(bounds.x),
        "runout_elevation_m": asdict(bounds.elevation),
        "interval": interval,
        "p_left_profile": bounds.p_left_profile,
        "p_not_released": bounds.p_not_released,
        "n_draws": bounds.n_draws,
        "n_nonpositive_friction": bounds.n_nonpositive,
    }
    if returned:
        row |= {
            "volume_interval_m3": {"q05": returned.q05_m3, "q95": returned.q95_m3},
            "volume_method": method,
            "extrapolated": returned.extrapolated,
        }
    return row
