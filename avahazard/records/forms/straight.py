"""A row of `events.csv` for an event without a profile: only its H and L are known."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from avahazard.records.forms.deposit import DepositRow
from avahazard.records.forms.row import Positive

WITHOUT_PATH = "empty, or a path_id with it"


class StraightRow(DepositRow):
    """An event on the straight line from release to stop: apparent friction H/L."""

    fall_height_m: Positive = Field(description="the height of fall H in metres, over 0")
    runout_length_m: Positive = Field(description="the horizontal reach L in metres, over 0")
    runout_elevation_m: None = Field(None, description=WITHOUT_PATH)
    runout_x_m: None = Field(None, description=WITHOUT_PATH)
    left_profile: Literal["0", "0.0"] | None = Field(None, description="0, or a path_id with it")
