"""A sample entry of `zones`."""

from __future__ import annotations

from avahazard.results.base import Rows
from avahazard.results.hazard import (
    Density,
    ExceededHere,
    PeriodDesign,
    Place,
    Quantiles,
    Zone,
    ZonedPath,
)
from tests.gis.results import DESIGN_RUNOUT


def entry(beyond: bool = False) -> ZonedPath:
    """One path, 81 places, two return periods; red is empty."""
    places = Rows(
        Place(
            x_m=100.0 + 10.0 * i,
            elevation_m=2000.0 - 5.0 * i,
            p_reach_per_year=0.0123,
            by_return_period=Rows(
                ExceededHere(
                    return_period_years=period,
                    extrapolated=period == 300.0,
                    speed_m_s=Quantiles(10.0 + i, 20.0 + i, 30.0 + i),
                    pressure_kpa=Quantiles(30.0, 120.0, 270.0),
                )
                for period in (30.0, 300.0)
            ),
        )
        for i in range(81)
    )
    black = "#000000"
    return ZonedPath(
        path_id="P01",
        limits="swiss",
        density_kg_m3=Density(300.0, 50.0),
        release_x_m=100.0,
        end_x_m=900.0,
        interval="what a year exceeds",
        designs=Rows(PeriodDesign(t, t == 300.0, DESIGN_RUNOUT) for t in (30.0, 300.0)),
        places=places,
        p_not_released=0.0,
        zones=Rows(
            (
                Zone("red", black, 100.0, 100.0, 700.0, 200.0, beyond=False, extrapolated=False),
                Zone("blue", black, 100.0, 900.0, 700.0, None, beyond=beyond, extrapolated=True),
            )
        ),
        notes=(),
    )
