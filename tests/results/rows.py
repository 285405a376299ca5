"""Made-up rows of `hazard`."""

from __future__ import annotations

from typing import Any

from avahazard.results.hazard import HazardRow, Spread

SPREAD = Spread(1900.4, 1200.0, 1800.0, 2600.0)
NOTHING = Spread(None, None, None, None)


def hazard_row(**more: Any) -> HazardRow:
    """Give the row of a volume, but for `more`."""
    fields: dict[str, Any] = {
        "path_id": "p",
        "return_period_years": None,
        "volume_m3": 123_456.0,
        "runout_x_m": SPREAD,
        "runout_elevation_m": SPREAD,
        "runout_x_steps_m": (),
        "interval": "what varies",
        "p_left_profile": 0.0,
        "p_not_released": 0.0,
        "n_draws": 100,
        "n_nonpositive_friction": 0,
    }
    return HazardRow(**fields | more)
