"""A row of `events.csv` for an event on a path with a profile."""

from __future__ import annotations

from typing import Self

from pydantic import Field, ValidationInfo, model_validator

from avahazard.records.forms.deposit import DepositRow
from avahazard.records.forms.row import ELEVATION, Flag, Name, Number, wrong


class EventRow(DepositRow):
    """An event on a path: its stop is a place along the profile, or beyond its end."""

    path_id: Name = Field(
        description="the path_id of a path, or fall_height_m and runout_length_m instead, "
        "or h_over_l"
    )
    runout_elevation_m: Number | None = Field(None, description=ELEVATION)
    runout_x_m: Number | None = Field(None, description="the distance along the profile in metres")
    left_profile: Flag = Field(False, description="0 or 1")
    fall_height_m: None = Field(None, description="empty, because path_id is given")
    runout_length_m: None = Field(None, description="empty, because path_id is given")
    h_over_l: None = Field(None, description="empty, because path_id is given")

    @model_validator(mode="after")
    def _runout_given(self, info: ValidationInfo) -> Self:
        needed = (info.context or {}).get("need_runout", True)
        given = self.runout_x_m is not None or self.runout_elevation_m is not None
        if needed and not given and not self.left_profile:
            raise wrong("runout_x_m", "runout_x_m or runout_elevation_m, or left_profile 1")
        return self
