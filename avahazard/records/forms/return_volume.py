"""Rows of the files that tell the frequency of volumes: of (T, V), and of snow depths."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from avahazard.records.forms.row import ID, PLAIN, Name, Positive, Row, Year


class ReturnVolumeRow(Row):
    """The volume of one return period on one path."""

    path_id: Name = Field(description=ID)
    return_period_years: Annotated[float, Field(gt=1, allow_inf_nan=False), PLAIN] = Field(
        description="a number of years over 1"
    )
    volume_m3: Positive = Field(description="a volume in m3, over 0")


class SnowDepthRow(Row):
    """A three-day snow depth; of several in one year the largest counts."""

    path_id: Name | None = Field(None, description=f"{ID}, or no such column: for all paths")
    year: Year = Field(description="the year of the winter's January")
    depth_m: Positive = Field(description="a depth in m, over 0")
