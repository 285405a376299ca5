"""Documents of bounds and zones, made up, for the maps of tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from avahazard.records.path import Profile
from tests.gis.surface import CODE, NORTH, WEST


def profile(path_id: str = "P", crs: str | None = CODE, east: float = 0.0) -> Profile:
    """Give a profile of 1000 m to the south with a corner, in map coordinates."""
    x = np.linspace(0.0, 1000.0, 21)
    part = np.clip(x - 500.0, 0.0, None)
    return Profile(
        path_id,
        x,
        2000.0 - 0.8 * x + 3e-4 * x**2,
        easting_m=WEST + east + 0.6 * part,
        northing_m=NORTH - (x - part) - 0.8 * part,
        crs=crs,
    )


def spread(low: float, q95: float | None) -> dict[str, float | None]:
    """Give the four statistics of one length."""
    mean = None if q95 is None else low + 60.0
    return {"mean": mean, "q05": low, "q50": low + 50.0, "q95": q95}


def bounds(path_id: str = "P", period: float | None = 100.0) -> dict[str, Any]:
    """Give a row of `hazard`: the upper bound of (a) lies past the end of the profile."""
    lengths = {
        "runout_x_m": spread(700.0, None),
        "runout_elevation_m": spread(1500.0, None),
        "interval": "what varies",
    }
    row = {
        "path_id": path_id,
        "return_period_years": period,
        "volume_m3": 20_000.0,
        "p_left_profile": 0.06,
        "n_draws": 100,
        **lengths,
        "natural": lengths,
        "parameters": lengths,
    }
    if period is not None:
        x = spread(800.0, 930.5)
        row["exceeded"] = {"runout_x_m": x, "runout_elevation_m": x, "interval": "uncertainty"}
    return row


def zones(path_id: str = "P") -> dict[str, Any]:
    """Give an entry of `zones`: red, blue past the end of the profile, and none of yellow."""
    pieces = (("red", "#c8102e", 100.0, 650.0), ("blue", "#0072b2", 650.0, 1200.0),
              ("yellow", "#f0e442", 1200.0, 1200.0))  # fmt: skip
    return {
        "path_id": path_id,
        "limits": "swiss",
        "zones": [
            {
                "zone": name,
                "color": color,
                "from_x_m": start,
                "to_x_m": end,
                "to_x_q05_m": end - 50.0,
                "to_x_q95_m": None,
                "beyond": end > 1000.0,
            }
            for name, color, start, end in pieces
        ],
    }
