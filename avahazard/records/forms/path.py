"""A row of `paths.csv`."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from avahazard.records.forms.row import ELEVATION, ID, Name, NotNegative, Number, Row, Year, wrong

YEAR = "a year"


class PathRow(Row):
    """What is known of a path apart from its profile."""

    path_id: Name = Field(description=ID)
    name: str | None = Field(None, description="text")
    location: str | None = Field(None, description="text")
    orientation: str | None = Field(None, description="text")
    section: Literal["channelled", "open"] | None = Field(
        None, description="channelled or open, or empty"
    )
    catchment_ha: NotNegative | None = Field(None, description="an area in hectares, not negative")
    release_elevation_m: Number | None = Field(None, description=ELEVATION)
    observed_from: Year | None = Field(None, description=YEAR)
    observed_to: Year | None = Field(None, description=YEAR)
    observed_below_m: Number | None = Field(None, description=ELEVATION)

    @model_validator(mode="after")
    def _years_in_order(self) -> Self:
        first, last = self.observed_from, self.observed_to
        if first is not None and last is not None and first > last:
            raise wrong("observed_from", f"a year not after observed_to, which is {last}")
        return self
