"""A row of `velocities.csv`."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from avahazard.records.forms.row import (
    ELEVATION,
    ID,
    Name,
    NotNegative,
    Number,
    Positive,
    Row,
    wrong,
)


class VelocityRow(Row):
    """One measured speed, at a distance along the profile or at an elevation."""

    event_id: Name = Field(description=ID)
    x_m: Number | None = Field(None, description="the distance along the profile in metres")
    elevation_m: Number | None = Field(None, description=ELEVATION)
    speed_m_s: NotNegative = Field(description="a speed in m/s, not negative")
    speed_sigma_m_s: Positive | None = Field(None, description="m/s, over 0")

    @model_validator(mode="after")
    def _place_given(self) -> Self:
        if self.x_m is None and self.elevation_m is None:
            raise wrong("x_m", "x_m or elevation_m")
        return self
