"""Documents of bounds and zones, made up, for the maps of tests."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.records.collection import Profile
from avahazard.results.hazard import (
    Design,
    FarthestRecord,
    HazardRow,
    MapPoint,
    PlaceQuantiles,
    RunoutInterval,
    Spread,
)
from tests.gis.surface import CODE, NORTH, WEST
from tests.results.samples import HAZARD_ROW


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


def spread(low: float, q95: float | None) -> Spread:
    """Give the four statistics of one length."""
    return Spread(None if q95 is None else low + 60.0, low, low + 50.0, q95)


DESIGN_RUNOUT = Design(
    runout_x_m=PlaceQuantiles(800.0, 850.0, 930.5),
    runout_elevation_m=PlaceQuantiles(1515.2, 1536.8, 1552.0),
    p_beyond=0.01,
    point=MapPoint(WEST + 210.0, NORTH - 780.0, CODE),
    farthest_record=FarthestRecord(900.0, "1950-02-13"),
    records_beyond=1,
    n_records=7,
    interval="uncertainty",
)


def bounds_row(path_id: str = "P", period: float | None = 100.0) -> HazardRow:
    """Give a row of `hazard`: the upper bound of (a) lies past the end of the profile."""
    both = (spread(700.0, None), spread(1500.0, None))
    apart = RunoutInterval(*both, "what varies")
    return replace(
        HAZARD_ROW,
        path_id=path_id,
        return_period_years=period,
        volume_m3=20_000.0,
        p_left_profile=0.06,
        runout_x_m=both[0],
        runout_elevation_m=both[1],
        natural=apart,
        parameters=apart,
        design=None if period is None else DESIGN_RUNOUT,
    )


def bounds(path_id: str = "P", period: float | None = 100.0) -> dict[str, Any]:
    """Give the same as the store keeps it."""
    return bounds_row(path_id, period).to_dict()


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
