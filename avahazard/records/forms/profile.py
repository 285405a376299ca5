"""A row of `profiles.csv`."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from avahazard.records.forms.row import ELEVATION, ID, PLAIN, Name, Number, Positive, Row, wrong

Longitude = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False), PLAIN]
Latitude = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False), PLAIN]


class ProfileRow(Row):
    """One point of a profile."""

    path_id: Name = Field(description=ID)
    x_m: Number = Field(description="the horizontal distance from the top of the path in metres")
    y_m: Number = Field(description=ELEVATION)
    land_cover: Name | None = Field(None, description="a word such as open or forest")
    easting_m: Number | None = Field(None, description="a map coordinate in metres")
    northing_m: Number | None = Field(None, description="a map coordinate in metres")
    crs: Name | None = Field(None, description="a coordinate system such as EPSG:31287")
    lon: Longitude | None = Field(None, description="degrees from -180 to 180")
    lat: Latitude | None = Field(None, description="degrees from -90 to 90")
    elevation_sigma_m: Positive | None = Field(
        None, description="the error of the elevation in metres, above 0"
    )

    @model_validator(mode="after")
    def _coordinates_in_pairs(self) -> Self:
        for first, second in (("easting_m", "northing_m"), ("lon", "lat")):
            given = [getattr(self, name) is not None for name in (first, second)]
            if given[0] != given[1]:
                missing = second if given[0] else first
                raise wrong(missing, f"{first} and {second}, both or neither")
        return self
