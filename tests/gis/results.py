"""Results of `hazard` and `zones`, made up, for the maps of tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.records.collection import Profile
from avahazard.results.base import Rows
from avahazard.results.hazard import (
    Density,
    Design,
    FarthestRecord,
    HazardRow,
    MapPoint,
    PlaceQuantiles,
    RunoutInterval,
    Spread,
    Zone,
    ZonedPath,
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


def zones(path_id: str = "P") -> ZonedPath:
    """Give an entry of `zones`: red, blue past the end of the profile, and none of yellow."""
    pieces = (("red", "#c8102e", 100.0, 650.0), ("blue", "#0072b2", 650.0, 1200.0),
              ("yellow", "#f0e442", 1200.0, 1200.0))  # fmt: skip
    found = [
        Zone(name, color, start, end, end - 50.0, None, end > 1000.0, extrapolated=False)
        for name, color, start, end in pieces
    ]
    return ZonedPath(
        path_id=path_id,
        limits="swiss",
        density_kg_m3=Density(300.0, 50.0),
        release_x_m=100.0,
        end_x_m=1000.0,
        interval="what a year exceeds",
        designs=Rows(),
        places=Rows(),
        p_not_released=0.0,
        zones=Rows(found),
        notes=(),
    )
